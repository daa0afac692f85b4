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
      0.0;  ///< RMS residual displacement of the fit, over x and y of the found spots
  double rms_waves = 0.0;  ///< root sum square of the coefficients without tilts (j = 1, 2)
  int used = 0;            ///< spots that were found and have a reference
  int lost = 0;            ///< spots that have a reference and were not found
};

/// Number of leading modes (columns of `slopes`, 2N x Z as from slope_matrix) that the whole
/// lattice determines: condition number below `max_condition`. 0 without spots or modes.
int determined_modes(const Eigen::MatrixXd& slopes, double max_condition = 1000.0);

/// Least-squares reconstructor a = P m - P ref: modes a, measured positions m, reference positions
/// ref, and P the pseudo-inverse of the slopes. P ref is precomputed. Immutable after construction.
///
/// A result is determined if the whole lattice determines the modes (condition number of the slopes
/// below 1000). Also, lost spots must not raise any mode's noise to more than kMaxNoiseGrowth times
/// its noise with all spots. A spot whose reference position is NaN, or whose slopes are all 0, is
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
  /// nothing is determined. `nuisance` (2N x K, or empty): displacement patterns that no mode
  /// causes. They are fitted together with the modes, but not reported.
  Reconstructor(const Eigen::MatrixXd& slopes, std::vector<int> modes_j,
                std::vector<Vec2> reference_px, const Eigen::MatrixXd& nuisance = {});

  const std::vector<int>& modes_j() const { return modes_j_; }
  /// The slopes given to the constructor, with rows of 0 for spots without a reference. A
  /// Reconstructor made from the result is identical.
  const Eigen::MatrixXd& slopes() const { return slopes_; }
  const Eigen::MatrixXd& nuisance() const { return nuisance_; }
  Scratch make_scratch() const;

  /// Writes modes_j().size() coefficients, RMS-normalised waves; all NaN if not determined. With
  /// all spots found this is one matrix-vector product. Otherwise it subtracts the rows of lost
  /// spots from the normal equations and solves them by Cholesky decomposition. `spots`: one fix
  /// per subaperture. RT-safe.
  Reconstruction solve(std::span<const SpotFix> spots, Scratch& scratch,
                       std::span<float> coefficients) const OVWS_NONBLOCKING;

  /// As `solve`, but rejects outliers first (leave-one-out): marks as lost, one after another, the
  /// spot in `spots` whose removal reduces the squared residuals most. It removes at most an eighth
  /// of the spots (at least 2, at most 16). It restores all removed spots unless the RMS residual
  /// per degree of freedom falls by the factor kOutlierRatio, with at least kMinFreedom degrees of
  /// freedom before and after. With so many spots and modes that the search takes longer than a
  /// frame, it rejects none. A fit with a residual up to `acceptable_px` is accepted unchanged.
  /// RT-safe.
  Reconstruction solve_without_outliers(std::span<SpotFix> spots, Scratch& scratch,
                                        std::span<float> coefficients,
                                        double acceptable_px) const OVWS_NONBLOCKING;
  /// Displacement of each spot that the modes of the last `solve` do not explain, camera pixels;
  /// NaN for spots not used. Requires a determined result. RT-safe.
  void residuals(std::span<const SpotFix> spots, const Scratch& scratch,
                 std::span<Vec2> left_px) const OVWS_NONBLOCKING;
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
  Eigen::MatrixXd inverse_;    ///< pseudo-inverse P: C x 2N
  Eigen::VectorXd offset_;     ///< P times the reference positions
  Eigen::MatrixXd normal_;     ///< columns^T columns
  Eigen::MatrixXd factor_;     ///< inverse of the lower Cholesky factor of `normal_`
  Eigen::VectorXd variances_;  ///< diagonal of the inverse of `normal_`
  int referenced_ = 0;         ///< spots with a reference
  bool determined_ = false;    ///< whether all spots together determine the modes
  Eigen::MatrixXd nuisance_;   ///< as given to the constructor
  Eigen::MatrixXd columns_;    ///< slopes_ | nuisance_: C columns; rows of 0 if without a reference
};

}  // namespace ovws
