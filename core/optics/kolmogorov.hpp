/// The spectrum of air: how strong its modes are.
#pragma once

#include <span>
#include <vector>

#include "core/optics/zernike.hpp"

namespace ovws {

/// The modes `first_j` (at least 3: the variance of tilts has no limit) to `last_j`, each with its
/// standard deviation in air, whose turbulence has Kolmogorov's spectrum (Noll, JOSA 66, 207,
/// 1976); RMS 1 wave together.
std::vector<Mode> air_modes(int first_j, int last_j);

/// The same of the modes of the 8 radial orders above those of `modes_j`, which hold two thirds to
/// three quarters of the variance above them.
std::vector<Mode> higher_modes(std::span<const int> modes_j);

}  // namespace ovws
