/// Mode operators (matrices between modes and spot displacements), computed from the optics model.
#pragma once

#include <span>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/mode_operator.hpp"

namespace ovws {

/// OSA indices of the modes to reconstruct: 1 .. Z_opt (paper eq. 5). The lattice may determine
/// fewer modes.
std::vector<int> reconstructed_modes(const SensorConfig& sensor);

/// Slope operator: the tilt of each mode over each subaperture, weighted as the tracker measures
/// it. Contains only modes that the lattice determines. Fast to compute.
ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            const TrackingConfig& tracking, const PxPerCycle& map);
/// Slope operator for tilts measured on rings of these radii (slope_matrix).
ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            std::span<const double> tilt_radii, const PxPerCycle& map);

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
