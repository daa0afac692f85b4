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
};

/// Immutable after construction. The reference is folded into the product: a = P m - P ref.
class Reconstructor {
 public:
  /// Working memory of one thread, so that `solve` never allocates.
  struct Scratch {
    Eigen::VectorXd measured;
    Eigen::VectorXd rhs;
    Eigen::MatrixXd normal;
    Eigen::VectorXd modes;
  };

  /// `slopes` as from slope_matrix (2N x Z). `reference_px` N positions, or empty: nothing is
  /// determined.
  Reconstructor(const Eigen::MatrixXd& slopes, std::vector<int> modes_j,
                std::vector<Vec2> reference_px);

  const std::vector<int>& modes_j() const { return modes_j_; }
  Scratch make_scratch() const;

  /// Writes modes_j().size() coefficients, RMS-normalised waves. With all spots found it is one
  /// prepared matrix product; with lost spots the normal equations are reduced by their rows and
  /// solved anew. RT-safe.
  Reconstruction solve(std::span<const SpotFix> spots, Scratch& scratch,
                       std::span<float> coefficients) const OVWS_NONBLOCKING;

 private:
  std::vector<int> modes_j_;
};

}  // namespace ovws
