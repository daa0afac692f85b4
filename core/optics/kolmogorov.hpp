/// Kolmogorov spectrum of air turbulence: standard deviation of each Zernike mode.
#pragma once

#include <span>
#include <vector>

#include "core/optics/zernike.hpp"

namespace ovws {

/// Kolmogorov turbulence (Noll, JOSA 66, 207, 1976): the modes `first_j` to `last_j`, each with its
/// standard deviation as coefficient, scaled to 1 wave RMS in total. `first_j` must be at least 3,
/// because the variance of piston and tilt diverges.
std::vector<Mode> air_modes(int first_j, int last_j);

/// Kolmogorov standard deviations (as air_modes) of the modes above the highest of `modes_j`, up to
/// 8 radial orders higher, at most kMaxZernikeIndex. These modes hold two thirds to three quarters
/// of the variance above `modes_j`.
std::vector<Mode> higher_modes(std::span<const int> modes_j);

}  // namespace ovws
