/// Slopes operator: the geometric matrix from modes to spot displacements.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// The tilt that a tracker measures as a spot's displacement (camera pixels). To first order it is
/// the first azimuthal harmonic of the phase phi (waves) inside a subaperture under a radial weight
/// q(r) of the tracker: (dx, dy) = S/R integral phi q(r) (cos t, sin t) dA / (1/2 integral r q(r)
/// dA). S: px_per_cycle. R: the subaperture's radius (SLM pixels). r: in units of R. A pure tilt
/// gives exactly S * gradient.
enum class SlopeKind {
  gradient_tilt,  ///< G-tilt, the mean gradient, measured by the centroid of a whole bright spot;
                  ///< all weight is on the rim (Gauss's theorem)
  zernike_tilt,   ///< Z-tilt, q = r, the best-fitting plane: measured by the core of a bright spot
  vortex_tilt,    ///< V-tilt, q = 1: measured by the very core of a vortex of charge +-1
  kernel_tilt,    ///< measured by the zero of Psi for a charge and a kernel radius; tends to V-tilt
                  ///< (charge +-1) and to Z-tilt (charge 0) for a small kernel
};

/// A tilt with its parameters.
struct SlopeModel {
  SlopeKind kind = SlopeKind::vortex_tilt;
  int charge = 1;
  double kernel_radius = 0.3;  ///< 1/e radius, units of lambda/d

  SlopeModel() = default;
  SlopeModel(SlopeKind k) : kind(k) {}  // NOLINT(google-explicit-constructor): a kind is a model
  SlopeModel(SlopeKind k, int l, double w) : kind(k), charge(l), kernel_radius(w) {}
};

/// The slope model of a tracker: kernel_tilt for fit, lg, lg_contour and weighted, Z-tilt for
/// thresholded, G-tilt for centroid.
SlopeModel slope_model(int charge, const TrackingConfig& tracking);

/// The textbook choice, regardless of the tracker: G-tilt for charge 0, V-tilt otherwise.
SlopeKind slope_kind(int charge);

/// 2N x Z matrix, rows x_0, y_0, x_1, y_1, …, columns as `modes_j`: camera pixels per
/// RMS-normalised wave. Integrals over each subaperture's circle by quadrature exact for the modes'
/// degree.
Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, const SlopeModel& model,
                             const PxPerCycle& px_per_cycle);

}  // namespace ovws
