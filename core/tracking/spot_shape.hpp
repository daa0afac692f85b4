/// The ideal spot as a continuous function of position.
#pragma once

#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

struct ShapeSample {
  double value = 0.0;         ///< about 1 at the maximum, about 0 far away
  double dx = 0.0, dy = 0.0;  ///< its gradient, 1/px
};

/// Ideal spot: far-field intensity of a circular subaperture of charge l, sampled at points as in
/// optics/far_field: I(r) = |2 pi integral_0^{1/2} J_l(2 pi r rho) rho d rho|^2, normalised to a
/// maximum of 1.
class ModelShape {
 public:
  /// Takes milliseconds. Beyond `reach` (lambda/d) the value is constant.
  ModelShape(const SpotModel& spots, double reach);

  /// At `from_centre` camera pixels from the spot's position. Thread-safe.
  ShapeSample at(Vec2 from_centre) const;

 private:
  double per_px_;              ///< table steps per camera pixel
  std::vector<double> table_;  ///< I(r), starting one step below r = 0
};

}  // namespace ovws
