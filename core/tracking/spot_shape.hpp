/// A spot as a continuous function of position: what templates are sampled from.
#pragma once

#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

struct ShapeSample {
  double value = 0.0;         ///< brightest about 1, far away about 0
  double dx = 0.0, dy = 0.0;  ///< its gradient, 1/px
};

class SpotShape {
 public:
  virtual ~SpotShape() = default;
  /// At `from_centre` camera pixels from the spot's position. Thread-safe.
  virtual ShapeSample at(Vec2 from_centre) const = 0;
};

/// The far field of a circular subaperture that carries a charge, sampled at points as
/// optics/far_field samples it: I(r) = |2 pi integral_0^{1/2} J_l(2 pi r rho) rho d rho|^2, its
/// maximum made 1.
class ModelShape final : public SpotShape {
 public:
  /// Takes milliseconds. Beyond `reach` (lambda/d) the value stays what it is there.
  ModelShape(const SpotModel& spots, double reach);

  ShapeSample at(Vec2 from_centre) const override;

 private:
  double per_px_;              ///< table steps per camera pixel
  std::vector<double> table_;  ///< of I(r), from one step below 0 on
};

}  // namespace ovws
