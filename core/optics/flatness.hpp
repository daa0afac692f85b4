/// SLM flatness correction: subtracts a measured phase error from the flatness map.
#pragma once

#include <memory>
#include <span>

#include "core/base/image.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Flatness map minus the measured phase error, in waves. Starts from the configured map, or from 0
/// if none is configured. `error_modes`: RMS-normalised waves over the pupil circle about the SLM's
/// centre. Outside this circle the configured map is unchanged.
std::shared_ptr<const Image<float>> flattened(const HologramConfig& configured,
                                              std::span<const Mode> error_modes,
                                              double pupil_diameter_px);

}  // namespace ovws
