/// Mode operator: the linear map from modes to spot displacements, whatever its origin.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/spots/measured_spots.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Mode operator; a Reconstructor applies its pseudo-inverse to spot displacements.
struct ModeOperator {
  OperatorKind kind = OperatorKind::slopes;  ///< origin of the matrix
  std::vector<int> modes_j;                  ///< OSA indices, one per column
  /// 2N x Z matrix as from slope_matrix: camera pixels per RMS-normalised wave. A spot with rows of
  /// 0 is not used.
  Eigen::MatrixXd slopes;
  /// Measured spot shapes, for kind `measured` with tracker `fit`: first of `modes_j`, then of
  /// further modes. Null: none.
  std::shared_ptr<const MeasuredShapes> shapes{};
};

}  // namespace ovws
