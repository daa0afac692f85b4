/// Rasterises a circle on a pixel grid, row by row.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/vec2.hpp"

namespace ovws {

/// Half-open range of pixel columns [begin, end) in one row.
struct Columns {
  int begin = 0;
  int end = 0;
};

/// Columns of pixel row y whose centres lie in or on the circle, on a grid `width` pixels wide.
/// begin == end if the circle does not reach the row.
inline Columns columns_in_circle(Vec2 centre_px, double diameter_px, int y, int width) {
  const double dy = y - centre_px.y;
  const double half_squared = 0.25 * diameter_px * diameter_px - dy * dy;
  if (half_squared < 0.0) return {};
  const double half = std::sqrt(half_squared);
  const int begin = std::max(0, int(std::ceil(centre_px.x - half)));
  return {begin, std::max(begin, std::min(width, int(std::floor(centre_px.x + half)) + 1))};
}

}  // namespace ovws
