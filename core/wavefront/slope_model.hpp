/// How far each spot moves for each mode: the matrix from modes to spot displacements.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

enum class SlopeKind {
  gradient_tilt,  ///< mean gradient over the subaperture (G-tilt): what the centroid of a bright
                  ///< spot follows
  vortex_tilt,    ///< first azimuthal harmonic with flat radial weight (V-tilt): what a vortex core
                  ///< follows
};

/// G-tilt for charge 0, V-tilt otherwise.
SlopeKind slope_kind(int charge);

/// 2N x Z matrix, rows x_0, y_0, x_1, y_1, …, columns as `modes_j`: camera pixels per
/// RMS-normalised wave. Integrals over each subaperture's circle by quadrature exact for the modes'
/// degree.
Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, SlopeKind kind,
                             double camera_px_per_cycle);

}  // namespace ovws
