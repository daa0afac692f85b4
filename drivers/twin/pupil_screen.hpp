/// Phase screen: turbulence over the pupil, interpolated from a coarse grid.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/base/vec2.hpp"
#include "drivers/twin/turbulence.hpp"

namespace ovws::twin {

/// Turbulence at one moment, sampled at about 96 points across the pupil with six-point Lagrange
/// interpolation. The error is within 1e-3 of the amplitude of the shortest waves, which are 8
/// points long. Immutable after construction, so thread-safe.
class PupilScreen {
 public:
  /// The pupil is given in SLM pixels and must be at least 1 pixel wide. `margin_px`: how far the
  /// screen extends beyond the pupil's square.
  PupilScreen(const Turbulence& turbulence, std::int64_t t_ns, Vec2 centre_px, double diameter_px,
              double margin_px = 0.0);

  /// Equally spaced positions along an axis, in SLM pixels.
  struct Positions {
    double first_px, step_px;
    int count;
  };
  /// Wavefront in waves at each pair of these positions, which must lie on the screen. Indices
  /// (y, x).
  Eigen::MatrixXf waves(const Positions& x, const Positions& y) const;

 private:
  int step_px_;             ///< grid step, SLM pixels
  Vec2 first_px_;           ///< grid point (0, 0)
  Eigen::MatrixXf points_;  ///< sampled wavefront, waves; indices (x, y)
};

}  // namespace ovws::twin
