/// Slopes operator: the geometric matrix from modes to spot displacements.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// Tilt definitions: every tracker measures the first azimuthal harmonic of the phase inside a
/// subaperture under some radial weight, scaled so that a tilt gives its gradient. Modes are nearly
/// cubic over a subaperture, so the weight acts like a ring. The ring's radius (unit: the
/// subaperture's radius) is the square root of the tilt that the tracker measures for r^3 cos t.
constexpr double kGradientTilt = 1.0;  ///< G-tilt: the mean gradient (Gauss's theorem)
constexpr double kZernikeTilt = 0.81649658092772603;  ///< Z-tilt: the best-fitting plane
constexpr double kVortexTilt = 0.77459666924148338;   ///< V-tilt: at the very core of a vortex

/// Ring radius of a tracker's tilt, unit: the subaperture's radius. `centroid` measures G-tilt and
/// `thresholded` Z-tilt. Trackers with a Gaussian kernel tend to V-tilt (charge +-1) or Z-tilt
/// (other charges) for a narrow kernel.
double tilt_radius(int charge, const TrackingConfig& tracking);
/// The same for each subaperture by its charge.
std::vector<double> tilt_radii(const Lattice& lattice, const TrackingConfig& tracking);
/// Ring radius of PositionFit for charges from -8 to 8, at a medium noise level: 6 electrons of
/// read noise for a peak of 500. Other noise levels change the tilt that it measures for a cubic
/// phase by up to 3 %.
double position_fit_tilt_radius(int charge);

/// Slopes matrix, 2N x Z: rows x_0, y_0, x_1, y_1, …, columns as `modes_j`: camera pixels per
/// RMS-normalised wave. `tilt_radii`: the tracker's ring radius in each subaperture, above 0.
Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, std::span<const double> tilt_radii,
                             const PxPerCycle& px_per_cycle);
/// The same with one radius for all subapertures.
Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, double tilt_radius,
                             const PxPerCycle& px_per_cycle);

}  // namespace ovws
