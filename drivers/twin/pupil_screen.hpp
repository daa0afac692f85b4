/// Phase screen: turbulence at the pupil's pixels, interpolated from a coarse grid.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <vector>

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

  /// Multiplies the pixels of row y that lie in the pupil by exp(2 pi i waves); `row` begins at
  /// column 0 and has `width` pixels.
  void modulate(int y, int width, std::complex<float>* row) const;
  /// The same for `count` values at every `step_px`-th pixel of row y, from first_x_px on. All must
  /// lie on the screen.
  void modulate(int y, int first_x_px, int step_px, int count, std::complex<float>* values) const;

 private:
  static constexpr int kTaps = 6;
  using Taps = std::array<float, kTaps>;

  Vec2 centre_px_;
  double diameter_px_;
  int step_px_;                  ///< grid step, SLM pixels
  int first_x_px_, first_y_px_;  ///< pixel of grid point 2: earlier points lack left neighbours
  Eigen::MatrixXf points_;       ///< sampled wavefront, waves; indices (x, y)
  std::vector<Taps> taps_;       ///< weights for each pixel between two grid points
};

}  // namespace ovws::twin
