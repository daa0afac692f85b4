/// Random aberrations for studies and tests.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "core/optics/zernike.hpp"

namespace ovws {

/// Random aberration: modes j = 3 .. `last_j` with normally distributed coefficients. The total RMS
/// is scaled to exactly `rms_waves`.
inline std::vector<Mode> random_modes(std::mt19937_64& random, int last_j, double rms_waves) {
  std::normal_distribution<double> normal;
  std::vector<Mode> modes;
  double squares = 0.0;
  for (int j = 3; j <= last_j; ++j) {
    modes.push_back({j, normal(random)});
    squares += modes.back().waves * modes.back().waves;
  }
  for (Mode& mode : modes) mode.waves *= rms_waves / std::sqrt(squares);
  return modes;
}

}  // namespace ovws
