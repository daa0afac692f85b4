#include "core/spots/spot_templates.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/cholesky.hpp"
#include "core/base/decompositions.hpp"
#include "core/spots/spot_sums.hpp"

namespace ovws {
namespace {

/// Orthonormal basis of level and background over the weighted pixels, in double precision.
struct Basis {
  Eigen::VectorXd root;   ///< square roots of the weights
  Eigen::VectorXd level;  ///< orthonormal
  Eigen::VectorXd background;

  /// Projects the weighted derivatives orthogonally to level and background.
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
    const double intensity_dn = level.intensity_dn * double(spot.light(c));
    const bool used = spot.window.is_lit(c) && intensity_dn < level.ceiling_dn;
    basis.root(c) = used ? 1.0 / std::sqrt(noise.variance(intensity_dn, pixels)) : 0.0;
    made.used += used ? 1 : 0;
    made.lit += spot.window.is_lit(c) ? 1 : 0;
    if (used) made.brightest_intensity = std::max(made.brightest_intensity, double(spot.light(c)));
  }
  basis.level = basis.root.cwiseProduct(spot.light.cast<double>());
  made.intensity_norm = basis.level.norm();
  basis.level /= made.intensity_norm;
  made.overlap = basis.root.dot(basis.level);
  basis.background = basis.root - made.overlap * basis.level;
  made.even_norm = basis.background.norm();
  basis.background /= made.even_norm;
  return basis;
}

/// Templates of a spot before its estimates are chosen.
struct Weighted {
  SpotTemplates made;
  Basis basis;
  bool used = false;
  Eigen::MatrixXd modes;     ///< weighted derivatives after Basis::free
  Eigen::MatrixXd products;  ///< modes^T modes
};

Weighted weighted(const RenderedSpot& spot, const CellLevel& level, const PixelNoise& noise,
                  int estimates) {
  Weighted spot_of;
  spot_of.made.window = spot.window;
  spot_of.made.place_px = spot.place_px;
  if (!(spot.light.maxCoeff() > 0.0F)) return spot_of;
  spot_of.basis = make_basis(spot, level, noise, spot_of.made);
  spot_of.used = 2 * spot_of.made.used >= spot_of.made.lit;
  if (!spot_of.used || estimates == 0) return spot_of;
  spot_of.modes = spot_of.basis.free(spot.per_wave);
  spot_of.products = gram_matrix(spot_of.modes);
  return spot_of;
}

/// Covariance of the modes from all pixels of all spots, up to a factor. The ridge limits the error
/// of an undetermined mode to a thousand times the error of the best-determined mode.
Eigen::MatrixXd covariance_of(std::span<const Weighted> spots, std::span<const CellLevel> levels) {
  constexpr double kRidge = 1e-6;
  Eigen::MatrixXd information;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Eigen::MatrixXd& products = spots[i].products;
    if (products.size() == 0) continue;
    if (information.size() == 0) information.setZero(products.rows(), products.cols());
    information += levels[i].intensity_dn * levels[i].intensity_dn * products;
  }
  const double most = information.size() > 0 ? information.diagonal().maxCoeff() : 0.0;
  if (!(most > 0.0)) return Eigen::MatrixXd::Identity(information.rows(), information.cols());
  information.diagonal().array() += kRidge * most;
  return most * Cholesky(information).inverse();
}

/// Chooses the estimates (leading singular vectors) and makes the template rows.
void finish(const RenderedSpot& spot, const Eigen::MatrixXd& covariance, int estimates,
            Weighted& spot_of) {
  const Basis& basis = spot_of.basis;
  const Eigen::MatrixXd& modes = spot_of.modes;
  SpotTemplates& made = spot_of.made;
  const Eigen::Index count = std::min<Eigen::Index>(estimates, modes.cols());
  Eigen::MatrixXd leading(spot.light.size(), count);
  if (count > 0) {
    // Singular vectors of modes * covariance, from its small square.
    const SymmetricEigen eigen = symmetric_eigen(covariance * spot_of.products * covariance);
    const Eigen::VectorXd values = eigen.values.tail(count).cwiseMax(0.0).cwiseSqrt();
    if (!(values.minCoeff() > 0.0)) return;
    const Eigen::MatrixXd worth =
        covariance * eigen.vectors.rightCols(count) * values.cwiseInverse().asDiagonal();
    leading.noalias() = modes * worth;
    made.per_wave.noalias() = worth.transpose() * spot_of.products;
  }
  if (count > 0 && spot.per_monomial.size() > 0) {
    made.higher = leading.transpose() * basis.free(spot.per_monomial) *
                  spot.higher.transpose().cast<double>();
  }

  const Eigen::MatrixXd moved = basis.free(spot.per_px);
  Eigen::MatrixXd rows(SpotTemplates::kFixed + count, spot.light.size());
  rows.row(SpotTemplates::kLevel) = basis.level.transpose();
  rows.row(SpotTemplates::kBackground) = basis.background.transpose();
  const Eigen::Matrix2d inverse = Eigen::Matrix2d(moved.transpose() * moved).inverse();
  rows.middleRows(SpotTemplates::kX, 2) = inverse * moved.transpose();
  made.px_error = std::sqrt(0.5 * inverse.trace());
  rows.bottomRows(count) = leading.transpose();
  const Eigen::Index cells = spot.light.size();
  made.rows.setZero(rows.rows(), padded(int(cells)));
  made.rows.leftCols(cells) = (rows * basis.root.asDiagonal()).cast<float>();
  made.weights.setZero(made.rows.cols());
  made.weights.head(cells) = basis.root.cwiseAbs2().cast<float>();
}

}  // namespace

HigherErrors higher_errors(const SpotTemplates& spot, double level_dn, double higher_waves) {
  // Error of polynomials of degree 3, relative; 0.06 to 0.17 for single modes of 19 vortices.
  constexpr double kUnlike = 0.13;
  if (spot.higher.size() == 0 || !(higher_waves > 0.0)) return {};
  HigherErrors errors{level_dn * higher_waves * spot.higher, 1.0, {}};
  errors.own += kUnlike * kUnlike * errors.shared.squaredNorm() / spot.estimates();
  Eigen::MatrixXd factor = gram_matrix(errors.shared.transpose());  // of the covariance
  factor.diagonal().array() += errors.own;
  factorise(factor);
  invert_lower(factor);
  errors.whitening = factor.triangularView<Eigen::Lower>();
  return errors;
}

std::vector<SpotTemplates> make_templates(std::span<const RenderedSpot> spots,
                                          std::span<const CellLevel> levels,
                                          const PixelNoise& noise, int estimates) {
  std::vector<Weighted> all;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    all.push_back(weighted(spots[i], levels[i], noise, estimates));
  }
  const Eigen::MatrixXd covariance = covariance_of(all, levels);
  std::vector<SpotTemplates> made;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (all[i].used) finish(spots[i], covariance, estimates, all[i]);
    made.push_back(std::move(all[i].made));
  }
  return made;
}

}  // namespace ovws
