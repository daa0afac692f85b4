/// The files of a study in its folder.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "daemon/ovws/study/figure.hpp"

namespace ovws::cli {

/// Takes away what `study` left in the folder when it ran there before, so that nothing of it
/// stands beside new numbers: summary.json, its figures, and what else the experiment writes. A
/// figure is known by its NAME.gnuplot, NAME being the study's or beginning with it and a hyphen;
/// no other file is touched. Errors (Errc::unavailable): a file cannot be removed.
Result<void> remove_findings(const std::string& study, const std::filesystem::path& folder);

/// In place of what the study left there before. The pictures come last: what is missing for them
/// must not cost the numbers. Errors (Errc::unavailable): as of remove_findings, study::draw, or a
/// file cannot be written.
Result<void> write_findings(const std::string& study, const nlohmann::json& summary,
                            const std::vector<study::Figure>& figures,
                            const std::filesystem::path& folder);

}  // namespace ovws::cli
