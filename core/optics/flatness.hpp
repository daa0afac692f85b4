/// SLM flatness correction: subtracts a measured phase error from the flatness map.
#pragma once

#include <memory>
#include <span>

#include "core/base/image.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// The configured flatness map (waves of phase to add, of the SLM's size; none: 0) minus the error.
/// `error_modes` are RMS-normalised waves over the pupil circle of `pupil_diameter_px` about the
/// SLM's centre. Outside the circle the map stays as configured.
std::shared_ptr<const Image<float>> flattened(const HologramConfig& configured,
                                              std::span<const Mode> error_modes,
                                              double pupil_diameter_px);

}  // namespace ovws
