/// The ideal spot as a continuous function of position.
#pragma once

#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

struct ShapeSample {
  double value = 0.0;         ///< about 1 at the maximum, about 0 far away
  double dx = 0.0, dy = 0.0;  ///< gradient of `value`, 1/px
};

/// Ideal spot: far-field intensity of a circular subaperture of charge l, sampled at points as in
/// optics/far_field: I(r) = |2 pi integral_0^{1/2} J_l(2 pi r rho) rho d rho|^2, normalised to a
/// maximum of 1.
class ModelShape {
 public:
  /// Tabulates the intensity, which takes milliseconds. Beyond `reach` (lambda/d) it is constant.
  ModelShape(const SpotModel& spots, double reach);

  /// Intensity and gradient at the offset `from_centre` from the spot, camera pixels. Thread-safe.
  ShapeSample at(Vec2 from_centre) const;

 private:
  double per_px_;              ///< table steps per camera pixel
  std::vector<double> table_;  ///< I(r), starting one step below r = 0
};

}  // namespace ovws
