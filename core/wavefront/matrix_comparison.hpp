/// Comparison of a measured interaction matrix with the model's: whether they agree, and if not,
/// what in the bench or in its configuration explains the difference.
#pragma once

#include <string>
#include <vector>

#include "core/wavefront/interaction_matrix.hpp"
#include "core/wavefront/mode_operator.hpp"

namespace ovws {

/// Comparison of a measured column m with the model's column s of one mode, over the spots in use.
struct ModeComparison {
  int j = 0;
  double factor = 0.0;  ///< regression: m = factor * s, by least squares
  double factor_standard_error = 0.0;
  double correlation = 0.0;  ///< (m . s) / (|m| |s|), -1 .. 1
};

enum class Disagreement {
  none,
  sign,          ///< wrong sign of all displacements, of x, of y, or of single modes
  axes,          ///< x and y exchanged
  scale,         ///< all displacements too long or too short
  rotation,      ///< displacements are rotated
  parity,        ///< wrong sign of the modes that a mirrored or rotated lattice inverts
  order,         ///< a column resembles the model's column of another mode
  single_modes,  ///< only some columns are too long or too short
  unlike,        ///< no simple change of the model explains the measurement
};

struct MatrixComparison {
  std::vector<ModeComparison> modes;  ///< in the order of the columns
  Disagreement disagreement = Disagreement::none;
  std::string words;  ///< human-readable diagnosis and remedy; empty if the matrices agree
};

/// Compares a measured interaction matrix with `model`, the operator that the plan uses without a
/// measurement (slope_operator). Measured modes that have no column in `model` are ignored.
MatrixComparison compare(const InteractionMatrix& measured, const ModeOperator& model);

}  // namespace ovws
