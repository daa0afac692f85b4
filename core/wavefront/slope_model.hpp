/// Slopes operator: the geometric matrix from modes to spot displacements.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// Every tracker measures the first azimuthal harmonic of the phase inside a subaperture under some
/// radial weight, scaled so that a tilt gives its gradient. Modes are nearly cubic over a
/// subaperture, so the weight acts like a ring: its radius, in units of the subaperture's, is the
/// root of the tilt that the tracker reads from r^3 cos t.
constexpr double kGradientTilt = 1.0;  ///< G-tilt: the mean gradient (Gauss's theorem)
constexpr double kZernikeTilt = 0.81649658092772603;  ///< Z-tilt: the best-fitting plane
constexpr double kVortexTilt = 0.77459666924148338;   ///< V-tilt: the very core of a vortex

/// The ring's radius for a tracker. `centroid` measures G-tilt and `thresholded` Z-tilt. Those
/// with a Gaussian kernel tend to V-tilt (charge +-1) or Z-tilt (others) for a narrow one.
double tilt_radius(int charge, const TrackingConfig& tracking);
/// That of PositionFit at a medium noise level: other levels change what it reads from cubic phase
/// by 1.8 %.
double position_fit_tilt_radius(int charge);

/// 2N x Z matrix, rows x_0, y_0, x_1, y_1, …, columns as `modes_j`: camera pixels per
/// RMS-normalised wave. `tilt_radius`: of the ring, above 0.
Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, double tilt_radius,
                             const PxPerCycle& px_per_cycle);

}  // namespace ovws
