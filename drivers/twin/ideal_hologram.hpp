/// Ideal hologram: the field modulation of a perfect SLM under perfect light.
#pragma once

#include <complex>

#include "core/base/image.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

enum class Pattern {
  sensor,   ///< the configured lattice: each subaperture's grating and vortex (paper eq. 4)
  grating,  ///< the base grating
};

/// exp(i phase) at each SLM pixel inside the subapertures, or for the grating inside the pupil; 0
/// elsewhere. Requires a configuration whose lattice is possible.
Image<std::complex<float>> ideal_hologram(const Config& config, Pattern pattern);

}  // namespace ovws::twin
