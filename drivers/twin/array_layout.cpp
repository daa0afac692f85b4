#include "drivers/twin/array_layout.hpp"

#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"

namespace ovws::twin {

std::vector<Vec2> lenslet_centres(const ArrayConfig& array) {
  std::vector<Vec2> centres;
  const int middle_row = (array.rows - 1) / 2;
  for (int row = 0; row < array.rows; ++row) {
    const bool aside = array.lattice == Grid::hexagonal && (row - middle_row) % 2 != 0;
    for (int column = 0; column < array.columns; ++column) {
      centres.push_back(
          {(column - (array.columns - 1) / 2.0 + (aside ? 0.5 : 0.0)) * array.pitch_um,
           (row - (array.rows - 1) / 2.0) * row_um(array)});
    }
  }
  return centres;
}

bool in_lenslet(const ArrayConfig& array, Vec2 at) {
  const double half = array.pitch_um / 2, x = std::abs(at.x), y = std::abs(at.y);
  switch (shape_of(array)) {
    case LensletShape::circle:
      return norm(at) <= half;
    case LensletShape::hexagon:  // two sides are perpendicular to x
      return x <= half && x / 2 + y * std::numbers::sqrt3 / 2 <= half;
    case LensletShape::square:
      break;
  }
  return x <= half && y <= half;
}

double lenslet_area(const ArrayConfig& array) {
  if (shape_of(array) != LensletShape::circle) return array.pitch_um * row_um(array);
  return std::numbers::pi * array.pitch_um * array.pitch_um / 4;
}

double plate_radians(const PlateConfig& plate, int charge, Vec2 from_centre_um) {
  const Vec2 at = from_centre_um - plate.shift_um;
  double angle = std::atan2(at.y, at.x);
  if (angle < 0.0) angle += kTwoPi;
  if (plate.levels > 0) {
    const double step = kTwoPi / plate.levels;
    angle = (std::floor(angle / step) + 0.5) * step;
  }
  return plate.depth * charge * angle;
}

}  // namespace ovws::twin
