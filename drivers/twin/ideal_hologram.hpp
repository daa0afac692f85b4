/// Ideal hologram: field modulation of an SLM without errors under a uniform plane wave.
#pragma once

#include <complex>

#include "core/base/image.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

enum class Pattern {
  sensor,   ///< the sensor's lattice: grating and vortex in each subaperture (paper eq. 4)
  grating,  ///< the base grating over the whole pupil
};

/// Ideal field exp(i phase) at each SLM pixel inside the subapertures (Pattern::grating: inside the
/// pupil); 0 elsewhere. Requires a configuration whose lattice is possible.
Image<std::complex<float>> ideal_hologram(const Config& config, Pattern pattern);

}  // namespace ovws::twin
