#include "core/tracking/spot_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/tracking/spot_geometry.hpp"

namespace ovws {
namespace {

constexpr double kStepsPerLambdaD = 80.0;  // cubic interpolation is then accurate to 1e-6

}  // namespace

ModelShape::ModelShape(const SpotModel& spots, double reach)
    : per_px_(kStepsPerLambdaD / spots.lambda_d_px) {
  const double peak = spot_intensity(spots.charge, spot_geometry(spots.charge).ring);
  const int last = int(std::ceil(reach * kStepsPerLambdaD)) + 2;
  table_.push_back(0.0);
  for (int k = 0; k <= last; ++k) {
    table_.push_back(spot_intensity(spots.charge, k / kStepsPerLambdaD) / peak);
  }
  table_[0] = table_[2];
}

// Catmull-Rom spline: its first derivative is continuous, too.
ShapeSample ModelShape::at(Vec2 from_centre) const {
  const double r = norm(from_centre);
  const double steps = std::min(r * per_px_, double(table_.size()) - 4.0);
  const auto k = std::size_t(steps);
  const double f = steps - double(k);
  const double a = table_[k], b = table_[k + 1], c = table_[k + 2], d = table_[k + 3];
  const double one = 0.5 * (c - a), two = a - 2.5 * b + 2.0 * c - 0.5 * d;
  const double three = 0.5 * (d - a) + 1.5 * (b - c);
  const double slope = per_px_ * (one + f * (2.0 * two + f * 3.0 * three));
  const double per_r = r > 0.0 ? slope / r : 0.0;
  return {b + f * (one + f * (two + f * three)), per_r * from_centre.x, per_r * from_centre.y};
}

}  // namespace ovws
