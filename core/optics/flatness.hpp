/// The SLM's flatness map with a measured phase error taken out.
#pragma once

#include <memory>
#include <span>

#include "core/base/image.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Waves of phase to add, of the SLM's size: the configured map minus the error. `error_modes` are
/// RMS-normalised waves over the pupil circle of `pupil_diameter_px` about the SLM's centre;
/// outside of it the map stays as configured.
std::shared_ptr<const Image<float>> flattened(const HologramConfig& configured,
                                              std::span<const Mode> error_modes,
                                              double pupil_diameter_px);

}  // namespace ovws
