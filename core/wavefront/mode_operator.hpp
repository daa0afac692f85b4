/// Mode operator: the linear map from modes to spot displacements, whatever its origin.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/spots/measured_spots.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// A Reconstructor applies the pseudo-inverse of it.
struct ModeOperator {
  OperatorKind kind = OperatorKind::slopes;  ///< what it was made from
  std::vector<int> modes_j;                  ///< OSA indices, one a column
  /// 2N x Z like that of slope_matrix: camera pixels per RMS-normalised wave. A spot with rows of 0
  /// is not used.
  Eigen::MatrixXd slopes;
  /// Positions that the tracker finds for a flat wavefront; NaN: not found. Empty if not computed.
  std::vector<Vec2> flat_px{};
  /// Kind `measured`, tracker `fit`: of `modes_j` first, and of further modes. Null: none.
  std::shared_ptr<const MeasuredShapes> shapes{};
};

}  // namespace ovws
