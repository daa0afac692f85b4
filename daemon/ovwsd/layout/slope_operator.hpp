/// Slope operator: the matrix between modes and spot displacements, computed from tilts.
#pragma once

#include <span>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
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

}  // namespace ovws
