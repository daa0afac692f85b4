/// SLM flatness correction: subtracts a measured phase error from the flatness map.
#pragma once

#include <memory>
#include <span>

#include "core/base/image.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Centre of a cell of a map over the pupil's square, pupil radii. `index`: row by row.
Vec2 cell_centre(int cells, int index);
/// Value of such a map at a point, pupil radii: bilinear between its cells that are not NaN; 0
/// where there is none.
float value_at(const Image<float>& map, Vec2 at);

/// Flatness map minus the measured phase error, in waves. Starts from the configured map, or from 0
/// if none is configured. `error_modes`: RMS-normalised waves over the pupil circle about the SLM's
/// centre. `fine`: the rest of the error as a map over the pupil's square; empty: none. Outside
/// this circle the configured map is unchanged.
std::shared_ptr<const Image<float>> flattened(const HologramConfig& configured,
                                              std::span<const Mode> error_modes,
                                              const Image<float>& fine, double pupil_diameter_px);

}  // namespace ovws
