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
  bool determined = false;  ///< the spots found determine all modes
  double fit_residual_px =
      0.0;  ///< RMS over the found spots' x and y of the displacements left by the fit
  double rms_waves = 0.0;  ///< root sum square of the coefficients without tilts (j = 1, 2)
  int used = 0;            ///< spots that were found and have a reference
  int lost = 0;            ///< spots that have a reference and were not found
};

/// How many leading columns of `slopes` (2N x Z, as from slope_matrix) the whole lattice
/// determines: condition number below 1000.
int determined_modes(const Eigen::MatrixXd& slopes);

/// Least-squares reconstructor a = P m - P ref: P is the pseudo-inverse of the slopes, and the
/// reference is folded in. Immutable after construction.
///
/// A result is determined if the whole lattice determines the modes (condition number of the slopes
/// below 1000), and if with the spots found no mode's noise is more than kMaxNoiseGrowth times its
/// noise with all spots. A spot whose reference position is NaN, or whose slopes are all 0, is
/// never used.
class Reconstructor {
 public:
  static constexpr double kMaxNoiseGrowth = 5.0;

  /// Working memory of one thread, so that `solve` never allocates.
  struct Scratch {
    Eigen::VectorXd measured;
    Eigen::VectorXd rhs;
    Eigen::MatrixXd normal;
    Eigen::VectorXd modes;
    bool reduced = false;  ///< `normal` holds the inverse Cholesky factor of the spots used
  };

  /// `slopes` as from slope_matrix (2N x Z). `reference_px`: N positions, or empty, in which case
  /// nothing is determined. `nuisance` (2N x K, or empty): patterns of displacement that no mode
  /// makes; they are fitted together with the modes, but not reported.
  Reconstructor(const Eigen::MatrixXd& slopes, std::vector<int> modes_j,
                std::vector<Vec2> reference_px, const Eigen::MatrixXd& nuisance = {});

  const std::vector<int>& modes_j() const { return modes_j_; }
  /// The slopes as given, with rows of 0 for spots without a reference. A Reconstructor made of
  /// them is the same.
  const Eigen::MatrixXd& slopes() const { return slopes_; }
  const Eigen::MatrixXd& nuisance() const { return nuisance_; }
  Scratch make_scratch() const;

  /// Writes modes_j().size() coefficients, RMS-normalised waves; all NaN if not determined. With
  /// all spots found this is one matrix-vector product. With lost spots, their rows are subtracted
  /// from the normal equations, which are then solved by Cholesky decomposition. `spots` holds N.
  /// RT-safe.
  Reconstruction solve(std::span<const SpotFix> spots, Scratch& scratch,
                       std::span<float> coefficients) const OVWS_NONBLOCKING;

  /// As `solve`, but first rejects outliers: marks spots in `spots` as lost, one after another,
  /// always the one whose removal reduces the squared residuals most (leave-one-out). It removes at
  /// most an eighth of the spots, within 2 to 16. It restores all of them unless the RMS residual
  /// per degree of freedom falls by the factor kOutlierRatio, with at least kMinFreedom degrees of
  /// freedom before and after. A residual up to `acceptable_px` is accepted as it is. RT-safe.
  Reconstruction solve_without_outliers(std::span<SpotFix> spots, Scratch& scratch,
                                        std::span<float> coefficients,
                                        double acceptable_px) const OVWS_NONBLOCKING;
  static constexpr double kOutlierRatio = 3.5;
  static constexpr int kMinFreedom = 8;

 private:
  bool usable(const SpotFix& spot, std::size_t i) const;
  bool solve_reduced(std::span<const SpotFix> spots, Scratch& scratch) const;
  double residual_px(std::span<const SpotFix> spots, const Scratch& scratch) const;
  Vec2 residual_of(std::size_t i, const Scratch& scratch) const;
  double spread(std::span<const SpotFix> spots, const Reconstruction& found) const;
  int worst_outlier(std::span<const SpotFix> spots, Scratch& scratch) const;

  std::vector<int> modes_j_;
  std::vector<Vec2> reference_px_;
  Eigen::MatrixXd slopes_;     ///< rows of spots without a reference are 0
  Eigen::MatrixXd inverse_;    ///< P: C x 2N
  Eigen::VectorXd offset_;     ///< P ref
  Eigen::MatrixXd normal_;     ///< columns^T columns
  Eigen::MatrixXd factor_;     ///< inverse of its lower Cholesky factor
  Eigen::VectorXd variances_;  ///< diagonal of the inverse of `normal_`
  int referenced_ = 0;         ///< spots with a reference
  bool determined_ = false;    ///< with all spots
  Eigen::MatrixXd nuisance_;   ///< as given
  Eigen::MatrixXd columns_;    ///< slopes_ and nuisance_, rows of 0 without a reference: C columns
};

}  // namespace ovws
