/// How far each spot moves for each mode: the matrix from modes to spot displacements.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// To first order, every tracker sees of the phase phi inside its subaperture the first azimuthal
/// harmonic under a radial weight q of its own (r in units of the subaperture's radius):
/// (dx, dy) = S integral phi q(r) (cos t, sin t) dA / (1/2 integral r q(r) dA), so that a pure tilt
/// gives exactly S * gradient.
enum class SlopeKind {
  gradient_tilt,  ///< G-tilt, the mean gradient: all weight on the rim (Gauss). What the centroid
                  ///< of a whole bright spot follows.
  zernike_tilt,   ///< q = r, the best-fitting plane: what the core of a bright spot follows
  vortex_tilt,    ///< V-tilt, q = 1: what the very core of a vortex of charge +-1 follows
  kernel_tilt,    ///< what the zero of the LG kernel's Psi follows, for its charge and its radius:
                  ///< tends to V-tilt (charge +-1) and to Z-tilt (charge 0) for a small kernel
  matched_tilt,   ///< what the matched filter follows, for its charge, weights between the
                  ///< extremes: as the light's noise is, the cubic part of phi differs by +-1.8 %
};

/// Which of them, with what kernel_tilt needs.
struct SlopeModel {
  SlopeKind kind = SlopeKind::vortex_tilt;
  int charge = 1;
  double kernel_radius = 0.3;  ///< 1/e radius; matched_tilt: the window's radius; units of lambda/d

  SlopeModel() = default;
  SlopeModel(SlopeKind k) : kind(k) {}  // NOLINT(google-explicit-constructor): a kind is a model
  SlopeModel(SlopeKind k, int l, double w) : kind(k), charge(l), kernel_radius(w) {}
};

/// The model of the tracker in use: kernel_tilt for lg, lg_contour and weighted, matched_tilt for
/// matched, Z-tilt for thresholded, G-tilt for centroid.
SlopeModel slope_model(int charge, const TrackingConfig& tracking);

/// The text-book choice without regard to the tracker: G-tilt for charge 0, V-tilt otherwise.
SlopeKind slope_kind(int charge);

/// 2N x Z matrix, rows x_0, y_0, x_1, y_1, …, columns as `modes_j`: camera pixels per
/// RMS-normalised wave. Integrals over each subaperture's circle by quadrature exact for the modes'
/// degree.
Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, const SlopeModel& model,
                             const PxPerCycle& px_per_cycle);

}  // namespace ovws
