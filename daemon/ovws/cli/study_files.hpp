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

/// File with the facts of a run that depend on the machine.
inline constexpr const char* kProvenance = "provenance.json";

/// Removes the files of an earlier run of `study`, so that old and new results do not mix:
/// summary.json, provenance.json, figures, and the other files of the experiment. A figure is
/// recognised by its script NAME.gnuplot, where NAME is the study's name, or starts with it and a
/// hyphen. No other file is touched. Errors (Errc::unavailable): a file cannot be removed.
Result<void> remove_findings(const std::string& study, const std::filesystem::path& folder);

/// Writes summary.json and the figures. Draws images and figures last, so that a drawing error does
/// not lose the numbers. Errors: a file cannot be written (Errc::unavailable), and errors of
/// `draw_images` and study::draw.
Result<void> write_findings(
    const nlohmann::json& summary, const std::vector<study::Figure>& figures,
    const std::filesystem::path& folder,
    const std::function<Result<void>()>& draw_images = [] { return Result<void>(); });

}  // namespace ovws::cli
