/// Report of `ovws check`: as one HTML file, as JSON, and as sentences.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/examine/check/judge.hpp"

namespace ovws::examine {

/// One HTML page that needs no other file, for screen and paper. Without gnuplot it has no curves,
/// and says so.
std::string report_html(const Measured& measured, const Findings& findings);

/// {"schema": "ovws.check/1", …}: findings, what to improve first, and the numbers.
nlohmann::json report_json(const Measured& measured, const Findings& findings);

/// "costs 0.0123 wave".
std::string cost_text(const Finding& one);

/// What to improve first, then one line per finding.
std::string report_text(const Findings& findings);

}  // namespace ovws::examine
