/// Least-squares reconstruction of modes from spot displacements, with any set of lost spots.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

struct Reconstruction {
  bool determined = false;  ///< enough spots, well enough placed, to tell all modes
  double fit_residual_px =
      0.0;                 ///< RMS over the found spots' x and y of what the modes do not explain
  double rms_waves = 0.0;  ///< root sum square of the coefficients without tilts (j = 1, 2)
  int used = 0;            ///< spots that were found and have a reference
  int lost = 0;            ///< spots that have a reference and were not found
};

/// How many of the first columns of `slopes` (2N x Z, as from slope_matrix) the whole lattice
/// tells: condition number below 1000.
int determined_modes(const Eigen::MatrixXd& slopes);

/// Immutable after construction. The reference is folded into the product: a = P m - P ref.
///
/// Determined means: the whole lattice tells the modes (condition number of the slopes below 1000),
/// and with the spots that are there no mode's noise is more than kMaxNoiseGrowth times what it
/// would be with all spots. A spot whose reference position is not a number, or whose slopes are
/// all 0, is always lost.
class Reconstructor {
 public:
  static constexpr double kMaxNoiseGrowth = 5.0;

  /// Working memory of one thread, so that `solve` never allocates.
  struct Scratch {
    Eigen::VectorXd measured;
    Eigen::VectorXd rhs;
    Eigen::MatrixXd normal;
    Eigen::VectorXd modes;
    bool reduced = false;  ///< `normal` holds the inverse factor of the spots that were solved for
  };

  /// `slopes` as from slope_matrix (2N x Z). `reference_px` N positions, or empty: nothing is
  /// determined. `nuisance` (2N x K, or empty): displacements that no mode makes; they are fitted
  /// together with the modes, and not reported.
  Reconstructor(const Eigen::MatrixXd& slopes, std::vector<int> modes_j,
                std::vector<Vec2> reference_px, const Eigen::MatrixXd& nuisance = {});

  const std::vector<int>& modes_j() const { return modes_j_; }
  /// As given, but for spots without a reference, whose rows are 0; a Reconstructor made of them is
  /// the same.
  const Eigen::MatrixXd& slopes() const { return slopes_; }
  const Eigen::MatrixXd& nuisance() const { return nuisance_; }
  Scratch make_scratch() const;

  /// Writes modes_j().size() coefficients, RMS-normalised waves; all NaN if not determined. With
  /// all spots found it is one prepared matrix product; with lost spots the normal equations are
  /// reduced by their rows and solved anew. `spots` holds N. RT-safe.
  Reconstruction solve(std::span<const SpotFix> spots, Scratch& scratch,
                       std::span<float> coefficients) const OVWS_NONBLOCKING;

  /// As solve, but outliers among the spots are lost first: by leave-one-out residuals the one that
  /// the others contradict most, one after another, at most an eighth of all and 2 at least. They
  /// stay in if the others, per degree of freedom, do not then agree kOutlierRatio times better
  /// (RMS), or fewer than kMinFreedom degrees are left to tell. A residual up to `credible_px` is
  /// not looked into. RT-safe.
  Reconstruction solve_without_outliers(std::span<SpotFix> spots, Scratch& scratch,
                                        std::span<float> coefficients,
                                        double credible_px) const OVWS_NONBLOCKING;
  static constexpr double kOutlierRatio = 3.5;
  static constexpr int kMinFreedom = 8;

 private:
  bool usable(const SpotFix& spot, std::size_t i) const;
  bool solve_reduced(std::span<const SpotFix> spots, Scratch& scratch) const;
  double residual_px(std::span<const SpotFix> spots, const Scratch& scratch) const;
  Vec2 residual_of(std::size_t i, const Scratch& scratch) const;
  double spread(std::span<const SpotFix> spots, const Reconstruction& found) const;
  int most_contradicted(std::span<const SpotFix> spots, Scratch& scratch) const;

  std::vector<int> modes_j_;
  std::vector<Vec2> reference_px_;
  Eigen::MatrixXd slopes_;     ///< rows of spots without a reference are 0
  Eigen::MatrixXd inverse_;    ///< P: C x 2N
  Eigen::VectorXd offset_;     ///< P ref
  Eigen::MatrixXd normal_;     ///< columns^T columns
  Eigen::MatrixXd factor_;     ///< inverse of its lower Cholesky factor
  Eigen::VectorXd variances_;  ///< diagonal of the inverse of `normal_`
  int referenced_ = 0;         ///< spots with a reference
  bool determined_ = false;    ///< with all of them
  Eigen::MatrixXd nuisance_;   ///< as given
  Eigen::MatrixXd columns_;    ///< slopes_, and nuisance_ without those spots: C columns
};

}  // namespace ovws
