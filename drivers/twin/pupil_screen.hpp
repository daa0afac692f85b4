/// A smooth wavefront over the pupil's pixels, from a coarse grid of points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <vector>

#include "core/base/vec2.hpp"
#include "drivers/twin/turbulence.hpp"

namespace ovws::twin {

/// One moment of the turbulence: 96 points across the pupil, between them Lagrange's polynomial
/// through six: within 1e-3 of the strength of the shortest waves, 8 points long. Immutable after
/// construction, so thread-safe.
class PupilScreen {
 public:
  /// The pupil on the SLM's pixels; at least 1 pixel wide.
  PupilScreen(const Turbulence& turbulence, std::int64_t t_ns, Vec2 centre_px, double diameter_px);

  /// Multiplies the pixels of row y that lie in the pupil by exp(2 pi i waves); `row` begins at
  /// column 0 and has `width` pixels.
  void modulate(int y, int width, std::complex<float>* row) const;

 private:
  static constexpr int kTaps = 6;
  using Taps = std::array<float, kTaps>;

  Vec2 centre_px_;
  double diameter_px_;
  int step_px_;                  ///< from point to point
  int first_x_px_, first_y_px_;  ///< pixel of point 2, the first that has all six
  Eigen::MatrixXf points_;       ///< waves, (along x, along y)
  std::vector<Taps> taps_;       ///< for each pixel between two points
};

}  // namespace ovws::twin
