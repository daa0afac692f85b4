/// Mode operators (matrices between modes and spot displacements), computed from the optics model.
#pragma once

#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/port/camera.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "daemon/ovwsd/layout/slope_operator.hpp"

namespace ovws {

/// Appends to `modes_j`, the modes that spot positions determine, the modes up to `mode_count` that
/// only spot shapes determine (tracker `fit` only).
std::vector<int> with_shapes(const TrackingSettings& tracking, std::vector<int> modes_j);

/// Displacements of the spots by each mode about a flat wavefront, computed from the model as
/// SpotMeter measures displacements in mean images: least squares of the pixels that the laser
/// reaches, equally weighted. Errors: those of SpotRenderer::make.
Result<ModeOperator> displacement_operator(const SensorConfig& sensor, const SlmGeometry& slm,
                                           const OpticsConfig& optics, const Roi& roi,
                                           const LitPixels& lit, std::vector<int> modes_j);

}  // namespace ovws
