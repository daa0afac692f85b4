/// Residual phase variance of a measured wavefront relative to the introduced one.
#pragma once

#include <numbers>
#include <span>

#include "core/optics/zernike.hpp"

namespace ovws {

/// The paper's residual variance of one frame, rad^2: 4 pi^2 times the sum of the squares of
/// `found_waves` (RMS-normalised, in the order of `modes_j`) minus `introduced`, tilts included.
/// Modes are orthonormal, so this is the mean square of the residual phase over the pupil. NaN if a
/// coefficient is NaN. Modes of `introduced` that are not among `modes_j` are ignored.
template <class Number>
double residual_variance_rad2(std::span<const int> modes_j, std::span<const Number> found_waves,
                              std::span<const Mode> introduced) {
  double sum = 0.0;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    double waves = double(found_waves[k]);
    for (const Mode& mode : introduced) waves -= mode.j == modes_j[k] ? mode.waves : 0.0;
    sum += waves * waves;
  }
  return 4.0 * std::numbers::pi * std::numbers::pi * sum;
}

}  // namespace ovws
