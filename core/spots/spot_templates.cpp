#include "core/spots/spot_templates.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/spots/spot_sums.hpp"

namespace ovws {
namespace {

/// Weighted cells, in double precision.
struct Basis {
  Eigen::VectorXd root;   ///< square roots of the weights
  Eigen::VectorXd level;  ///< orthonormal
  Eigen::VectorXd background;

  /// The weighted derivatives without what level and background make.
  Eigen::MatrixXd free(const Eigen::MatrixXf& derivative) const {
    Eigen::MatrixXd d = root.asDiagonal() * derivative.cast<double>();
    d -= level * (level.transpose() * d);
    d -= background * (background.transpose() * d);
    return d;
  }
};

Basis make_basis(const RenderedSpot& spot, const CellLevel& level, const PixelNoise& noise,
                 SpotTemplates& made) {
  const Eigen::Index cells = spot.light.size();
  const int pixels = spot.window.bin * spot.window.bin;
  Basis basis;
  basis.root.resize(cells);
  for (Eigen::Index c = 0; c < cells; ++c) {
    const double light_dn = level.light_dn * double(spot.light(c));
    const bool used = light_dn < level.ceiling_dn;
    basis.root(c) = used ? 1.0 / std::sqrt(noise.variance(light_dn, pixels)) : 0.0;
    made.used += used ? 1 : 0;
    if (used) made.brightest_light = std::max(made.brightest_light, double(spot.light(c)));
  }
  basis.level = basis.root.cwiseProduct(spot.light.cast<double>());
  made.light_norm = basis.level.norm();
  basis.level /= made.light_norm;
  made.overlap = basis.root.dot(basis.level);
  basis.background = basis.root - made.overlap * basis.level;
  made.even_norm = basis.background.norm();
  basis.background /= made.even_norm;
  return basis;
}

}  // namespace

SpotTemplates make_templates(const RenderedSpot& spot, const CellLevel& level,
                             const PixelNoise& noise, int estimates) {
  SpotTemplates made;
  made.window = spot.window;
  made.place_px = spot.place_px;
  if (!(spot.light.maxCoeff() > 0.0F)) return made;
  const Basis basis = make_basis(spot, level, noise, made);
  if (2 * made.used < spot.light.size()) return made;
  const Eigen::MatrixXd modes = basis.free(spot.per_wave);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(modes.transpose() * modes);
  const Eigen::Index count = std::min<Eigen::Index>(estimates, modes.cols());
  const Eigen::MatrixXd leading = eigen.eigenvectors().rightCols(count);
  const Eigen::VectorXd values = eigen.eigenvalues().tail(count).cwiseMax(0.0).cwiseSqrt();
  if (!(values.minCoeff() > 0.0)) return made;
  made.per_wave = values.asDiagonal() * leading.transpose();

  const Eigen::MatrixXd moved = basis.free(spot.per_px);
  Eigen::MatrixXd rows(SpotTemplates::kFixed + count, spot.light.size());
  rows.row(SpotTemplates::kLevel) = basis.level.transpose();
  rows.row(SpotTemplates::kBackground) = basis.background.transpose();
  const Eigen::Matrix2d inverse = Eigen::Matrix2d(moved.transpose() * moved).inverse();
  rows.middleRows(SpotTemplates::kX, 2) = inverse * moved.transpose();
  made.px_error = std::sqrt(0.5 * inverse.trace());
  rows.bottomRows(count) =
      values.cwiseInverse().asDiagonal() * leading.transpose() * modes.transpose();
  const Eigen::Index cells = spot.light.size();
  made.rows.setZero(rows.rows(), padded(int(cells)));
  made.rows.leftCols(cells) = (rows * basis.root.asDiagonal()).cast<float>();
  made.weights.setZero(made.rows.cols());
  made.weights.head(cells) = basis.root.cwiseAbs2().cast<float>();
  return made;
}

}  // namespace ovws
