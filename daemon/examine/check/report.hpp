/// Report of `ovws check`: as one HTML file, as JSON, and as sentences.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/examine/check/judge.hpp"
#include "daemon/ovws/study/figure.hpp"

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

/// Slopes, noise, drift, Allan deviation, and the loop; those for which there are numbers.
std::vector<study::Figure> figures_of(const Measured& measured);

/// The response as a matrix of coloured cells, an SVG element: columns are the modes shown, rows
/// the modes read. Each cell has its value as a title. Blue is positive, red negative; cross-talk
/// is shown as if it were ten times as strong.
std::string matrix_svg(const Response& response);

}  // namespace ovws::examine
