/// Writes and removes the files of a study in its folder.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "daemon/ovws/study/figure.hpp"

namespace ovws::cli {

/// Removes the files of an earlier run of `study`, so that they do not mix with new ones:
/// summary.json, figures, and the experiment's other files. A figure is recognised by NAME.gnuplot,
/// where NAME is the study's or starts with it and a hyphen; no other file is touched.
/// Errors (Errc::unavailable): a file cannot be removed.
Result<void> remove_findings(const std::string& study, const std::filesystem::path& folder);

/// Writes summary.json and the figures. Images and figures are drawn last, so that an error in
/// drawing does not lose the numbers. Errors (Errc::unavailable): a file cannot be written, or
/// those of `draw_images` and study::draw.
Result<void> write_findings(
    const nlohmann::json& summary, const std::vector<study::Figure>& figures,
    const std::filesystem::path& folder,
    const std::function<Result<void>()>& draw_images = [] { return Result<void>(); });

}  // namespace ovws::cli
