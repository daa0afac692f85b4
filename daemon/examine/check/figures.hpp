/// Figures of the report of `ovws check`.
#pragma once

#include <string>
#include <vector>

#include "daemon/examine/check/measured.hpp"
#include "daemon/ovws/study/figure.hpp"

namespace ovws::examine {

/// Slopes, noise, drift, Allan deviation, and the loop; those for which there are numbers.
std::vector<study::Figure> figures_of(const Measured& measured);

/// The response as a matrix of coloured cells, an SVG element: columns are the modes shown, rows
/// the modes read. Each cell has its value as a title. Blue is positive, red negative; cross-talk
/// is shown as if it were ten times as strong.
std::string matrix_svg(const Response& response);

}  // namespace ovws::examine
