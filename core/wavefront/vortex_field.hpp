/// Far field of a vortex that fills the pupil, and its derivatives.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/wavefront/vortex_path.hpp"

namespace ovws {

/// Fourier integral U(p) over the pupil at any camera pixels: U = sum A exp(2 pi i W) V exp(-2 pi i
/// p q) over square cells, where q is the position in the pupil in cycles per camera pixel. Exact
/// for any affine registration. Immutable after construction.
class VortexField {
 public:
  /// `waves_j`, `amplitude_j`: Zernike indices of the phase and of ln(amplitude).
  VortexField(const VortexBeam& beam, std::vector<int> waves_j, std::vector<int> amplitude_j);

  /// Number of coefficients: of the phase (waves), then of ln(amplitude).
  Eigen::Index coefficients() const { return basis_.cols(); }
  /// Field in the pupil with these coefficients and the vortex's axis at `axis` (pupil radii).
  Eigen::MatrixXcd pupil(const Eigen::VectorXd& coefficients, Vec2 axis) const;
  /// Far field at the pixels (x[c], y[r]), in row r and column c; (0, 0): where a beam without tilt
  /// has its middle.
  Eigen::MatrixXcd far(const Eigen::MatrixXcd& pupil, const Eigen::VectorXd& x,
                       const Eigen::VectorXd& y) const;
  /// Derivative of the pupil's field for coefficient k.
  Eigen::MatrixXcd derivative(const Eigen::MatrixXcd& pupil, Eigen::Index k) const;
  /// Zero of the field, camera pixels as in far(), by Newton's method from where a beam without an
  /// aberration has it about `middle`. None: it does not converge within 2 lambda/D of `middle`.
  std::optional<Vec2> core(const Eigen::MatrixXcd& pupil, Vec2 axis, Vec2 middle) const;
  /// Displacement of the beam by a tilt, j = 1 or 2; camera pixels per wave.
  Vec2 tilt_px(int j) const;

 private:
  /// Gradients of far() along x and y.
  std::array<Eigen::MatrixXcd, 2> gradient(const Eigen::MatrixXcd& pupil, const Eigen::VectorXd& x,
                                           const Eigen::VectorXd& y) const;
  VortexBeam beam_;
  Eigen::VectorXd qx_, qy_;    ///< cells, cycles per camera pixel
  Eigen::MatrixXd amplitude_;  ///< lit share of each cell, rows along y
  Eigen::MatrixXd x_, y_;      ///< cells, pupil radii
  Eigen::MatrixXd basis_;      ///< a mode in each column, cells column by column
  Eigen::Index phases_ = 0;    ///< number of modes of the phase
};

}  // namespace ovws
