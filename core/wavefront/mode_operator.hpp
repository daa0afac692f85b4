/// The linear operator between modes and spot displacements, whatever it was made from.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// What displacements are turned into modes with: a Reconstructor is its pseudo-inverse.
struct ModeOperator {
  OperatorKind kind = OperatorKind::slopes;  ///< what it was made from
  std::vector<int> modes_j;                  ///< OSA indices, one a column
  /// 2N x Z like that of slope_matrix: camera pixels per RMS-normalised wave. A spot with rows of 0
  /// tells nothing.
  Eigen::MatrixXd slopes;
  /// Where the tracker finds each spot of the flat sensor, if that was asked; NaN: nowhere.
  std::vector<Vec2> flat_px{};
};

}  // namespace ovws
