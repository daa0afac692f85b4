#include "core/wavefront/reconstructor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/cholesky.hpp"
#include "core/base/decompositions.hpp"

namespace ovws {
namespace {

constexpr double kMaxModesCondition = 1000.0;
/// Multiplications of one search for the worst spot, some milliseconds. One of so many spots hardly
/// changes the modes.
constexpr double kMaxOutlierWork = 4e6;

/// Whether the condition number is below `most`. `squares`: squared singular values of the slopes,
/// increasing.
bool well_conditioned(const Eigen::VectorXd& squares, double most = kMaxModesCondition) {
  const Eigen::Index count = squares.size();
  return count > 0 && squares(0) * most * most > squares(count - 1);
}

bool well_conditioned(const Eigen::MatrixXd& normal, Eigen::Index modes, double most) {
  return well_conditioned(symmetric_eigenvalues(normal.topLeftCorner(modes, modes)), most);
}

}  // namespace

int determined_modes(const Eigen::MatrixXd& slopes, double max_condition) {
  if (slopes.size() == 0) return 0;
  const Eigen::MatrixXd normal = gram_matrix(slopes);
  Eigen::Index determined = 0;
  Eigen::Index too_many = std::min(slopes.rows(), slopes.cols()) + 1;
  if (well_conditioned(normal, too_many - 1, max_condition)) return int(too_many) - 1;
  while (too_many - determined > 1) {  // bisection: one more mode never improves the condition
    const Eigen::Index middle = (determined + too_many) / 2;
    (well_conditioned(normal, middle, max_condition) ? determined : too_many) = middle;
  }
  return int(determined);
}

Reconstructor::Reconstructor(const Eigen::MatrixXd& slopes, std::vector<int> modes_j,
                             std::vector<Vec2> reference_px, const Eigen::MatrixXd& nuisance)
    : modes_j_(std::move(modes_j)),
      reference_px_(std::move(reference_px)),
      slopes_(slopes),
      nuisance_(nuisance) {
  reference_px_.resize(std::size_t(slopes.rows() / 2), Vec2{NAN, NAN});
  Eigen::VectorXd reference = Eigen::VectorXd::Zero(slopes.rows());
  for (std::size_t i = 0; i < reference_px_.size(); ++i) {
    const bool has_slopes = !slopes_.middleRows(2 * i, 2).isZero(0.0);
    if (!has_slopes || !std::isfinite(reference_px_[i].x) || !std::isfinite(reference_px_[i].y)) {
      reference_px_[i] = {NAN, NAN};
      slopes_.middleRows(2 * i, 2).setZero();
      continue;
    }
    reference(2 * i) = reference_px_[i].x;
    reference(2 * i + 1) = reference_px_[i].y;
    ++referenced_;
  }
  columns_.resize(slopes_.rows(), slopes_.cols() + nuisance_.cols());
  columns_.leftCols(slopes_.cols()) = slopes_;
  if (nuisance_.cols() > 0) columns_.rightCols(nuisance_.cols()) = nuisance_;
  for (std::size_t i = 0; i < reference_px_.size(); ++i) {
    if (std::isnan(reference_px_[i].x)) columns_.middleRows(2 * i, 2).setZero();
  }
  if (2 * Eigen::Index(referenced_) < columns_.cols()) return;
  normal_ = gram_matrix(columns_);
  const auto [values, vectors] = symmetric_eigen(normal_);
  determined_ = well_conditioned(values);
  if (!determined_) return;
  inverse_ =
      vectors * values.cwiseInverse().asDiagonal() * vectors.transpose() * columns_.transpose();
  offset_ = inverse_ * reference;
  variances_ = inverse_.rowwise().squaredNorm();
  factor_ = normal_;
  factorise(factor_);
  invert_lower(factor_);
}

Reconstructor::Scratch Reconstructor::make_scratch() const {
  return {Eigen::VectorXd::Zero(columns_.rows()), Eigen::VectorXd::Zero(columns_.cols()),
          Eigen::MatrixXd::Zero(columns_.cols(), columns_.cols()),
          Eigen::VectorXd::Zero(columns_.cols()), false};
}

bool Reconstructor::usable(const SpotFix& spot, std::size_t i) const {
  return spot.found() && std::isfinite(reference_px_[i].x) && std::isfinite(reference_px_[i].y);
}

Reconstruction Reconstructor::solve(std::span<const SpotFix> spots, Scratch& scratch,
                                    std::span<float> coefficients) const {
  Reconstruction result;
  std::fill(coefficients.begin(), coefficients.end(), std::numeric_limits<float>::quiet_NaN());
  int found = 0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const bool there = usable(spots[i], i);
    found += there ? 1 : 0;
    scratch.measured(2 * i) = there ? double(spots[i].x) : 0.0;
    scratch.measured(2 * i + 1) = there ? double(spots[i].y) : 0.0;
  }
  result.used = found;
  result.lost = referenced_ - found;
  if (!determined_ || 2 * Eigen::Index(found) < columns_.cols()) return result;
  scratch.reduced = found != referenced_;
  if (!scratch.reduced) {
    scratch.modes.noalias() = inverse_ * scratch.measured;
    scratch.modes -= offset_;
  } else if (!solve_reduced(spots, scratch)) {
    return result;
  }
  result.determined = true;
  double sum = 0.0;
  for (std::size_t k = 0; k < modes_j_.size(); ++k) {
    coefficients[k] = float(scratch.modes(k));
    if (modes_j_[k] > 2) sum += scratch.modes(k) * scratch.modes(k);
  }
  result.rms_waves = std::sqrt(sum);
  result.fit_residual_px = residual_px(spots, scratch);
  return result;
}

bool Reconstructor::solve_reduced(std::span<const SpotFix> spots, Scratch& scratch) const {
  const Eigen::Index modes = columns_.cols();
  scratch.normal = normal_;
  scratch.rhs.setZero();
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const auto x = columns_.row(2 * i), y = columns_.row(2 * i + 1);
    if (usable(spots[i], i)) {
      const double dx = scratch.measured(2 * i) - reference_px_[i].x;
      const double dy = scratch.measured(2 * i + 1) - reference_px_[i].y;
      for (Eigen::Index k = 0; k < modes; ++k) scratch.rhs(k) += x(k) * dx + y(k) * dy;
    } else {
      for (Eigen::Index k = 0; k < modes; ++k) {
        for (Eigen::Index j = k; j < modes; ++j) {
          scratch.normal(j, k) -= x(j) * x(k) + y(j) * y(k);
        }
      }
    }
  }
  if (!factorise(scratch.normal)) return false;
  invert_lower(scratch.normal);  // L^-1: the solution is L^-T (L^-1 rhs)
  for (Eigen::Index k = modes - 1; k >= 0; --k) {
    double sum = 0.0;
    for (Eigen::Index j = 0; j <= k; ++j) sum += scratch.normal(k, j) * scratch.rhs(j);
    scratch.rhs(k) = sum;
  }
  for (Eigen::Index k = 0; k < modes; ++k) {
    double sum = 0.0, variance = 0.0;
    for (Eigen::Index j = k; j < modes; ++j) {
      sum += scratch.normal(j, k) * scratch.rhs(j);
      variance += scratch.normal(j, k) * scratch.normal(j, k);
    }
    if (variance > kMaxNoiseGrowth * kMaxNoiseGrowth * variances_(k)) return false;
    scratch.modes(k) = sum;
  }
  return true;
}

Reconstruction Reconstructor::solve_without_outliers(std::span<SpotFix> spots, Scratch& scratch,
                                                     std::span<float> coefficients,
                                                     double acceptable_px) const {
  constexpr int kMaxRemoved = 16;
  std::array<std::pair<std::size_t, SpotFix>, kMaxRemoved> lost;
  const int max_removed = std::clamp(int(spots.size()) / 8, 2, kMaxRemoved);
  const Reconstruction all = solve(spots, scratch, coefficients);
  if (!all.determined || !(all.fit_residual_px > acceptable_px)) return all;
  const double columns = double(columns_.cols());
  if (double(spots.size()) * columns * columns > kMaxOutlierWork) return all;
  const double max_spread = spread(spots, all) / kOutlierRatio;
  if (!std::isfinite(max_spread)) return all;
  int count = 0;
  while (count < max_removed) {
    const int worst = worst_outlier(spots, scratch);
    if (worst < 0) break;
    SpotFix& spot = spots[std::size_t(worst)];
    lost[std::size_t(count++)] = {std::size_t(worst), spot};
    spot = SpotFix{.peak = spot.peak};
    const Reconstruction rest = solve(spots, scratch, coefficients);
    if (rest.determined && spread(spots, rest) <= max_spread) return rest;
    if (!rest.determined) break;
  }
  for (int k = 0; k < count; ++k) spots[lost[std::size_t(k)].first] = lost[std::size_t(k)].second;
  return solve(spots, scratch, coefficients);
}

/// RMS of the residual per degree of freedom; infinite with fewer than kMinFreedom degrees.
double Reconstructor::spread(std::span<const SpotFix> spots, const Reconstruction& found) const {
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < spots.size(); ++i) count += usable(spots[i], i) ? 2 : 0;
  const auto freedom = double(count - columns_.cols());
  if (freedom < kMinFreedom) return std::numeric_limits<double>::infinity();
  return found.fit_residual_px * std::sqrt(double(count) / freedom);
}

/// Deletion diagnostics: the used spot whose removal reduces the squared residuals most; -1 if no
/// spot is redundant enough to be checked by the others.
int Reconstructor::worst_outlier(std::span<const SpotFix> spots, Scratch& scratch) const {
  constexpr double kMinRedundancy = 0.01;  // determinant of 1 - H: redundancy of the spot
  const Eigen::MatrixXd& factor = scratch.reduced ? scratch.normal : factor_;
  const Eigen::Index modes = columns_.cols();
  int worst = -1;
  double most = 0.0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (!usable(spots[i], i)) continue;
    double xx = 1.0, xy = 0.0, yy = 1.0;  // 1 - H, H the spot's block of the hat matrix
    for (Eigen::Index k = 0; k < modes; ++k) {
      double x = 0.0, y = 0.0;
      for (Eigen::Index j = 0; j <= k; ++j) {
        x += factor(k, j) * columns_(2 * Eigen::Index(i), j);
        y += factor(k, j) * columns_(2 * Eigen::Index(i) + 1, j);
      }
      xx -= x * x, xy -= x * y, yy -= y * y;
    }
    const double det = xx * yy - xy * xy;
    if (!(det > kMinRedundancy)) continue;
    const Vec2 e = residual_of(i, scratch);
    const double less = (yy * e.x * e.x - 2.0 * xy * e.x * e.y + xx * e.y * e.y) / det;
    if (!(less > most)) continue;
    most = less;
    worst = int(i);
  }
  return worst;
}

Vec2 Reconstructor::residual_of(std::size_t i, const Scratch& scratch) const {
  const Eigen::Index row = 2 * Eigen::Index(i);
  return {
      scratch.measured(row) - reference_px_[i].x - columns_.row(row).dot(scratch.modes),
      scratch.measured(row + 1) - reference_px_[i].y - columns_.row(row + 1).dot(scratch.modes)};
}

void Reconstructor::residuals(std::span<const SpotFix> spots, const Scratch& scratch,
                              std::span<Vec2> left_px) const OVWS_NONBLOCKING {
  for (std::size_t i = 0; i < spots.size(); ++i) {
    left_px[i] = usable(spots[i], i) ? residual_of(i, scratch) : Vec2{NAN, NAN};
  }
}

double Reconstructor::residual_px(std::span<const SpotFix> spots, const Scratch& scratch) const {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (!usable(spots[i], i)) continue;
    const Vec2 e = residual_of(i, scratch);
    sum += e.x * e.x + e.y * e.y;
    count += 2;
  }
  return count == 0 ? 0.0 : std::sqrt(sum / count);
}

}  // namespace ovws
