/// A measured interaction matrix against the model's: whether they agree, and if not, what of the
/// bench or of its configuration would explain it.
#pragma once

#include <string>
#include <vector>

#include "core/wavefront/interaction_matrix.hpp"

namespace ovws {

/// A measured column m against the model's column s of the same mode, over the spots that tell.
struct ModeComparison {
  int j = 0;
  double factor = 0.0;  ///< regression: m = factor * s, by least squares
  double factor_standard_error = 0.0;
  double correlation = 0.0;  ///< (m . s) / (|m| |s|), -1 .. 1
};

enum class Disagreement {
  none,
  sign,          ///< of all, of x or of y
  axes,          ///< x and y exchanged
  scale,         ///< all too long or too short
  rotation,      ///< the displacements are turned
  parity,        ///< modes are upside down that a mirrored or turned lattice puts upside down
  order,         ///< a column looks like the model's of another mode
  single_modes,  ///< some columns only are of another length
  unlike,        ///< nothing of these
};

struct MatrixComparison {
  std::vector<ModeComparison> modes;  ///< in the order of the columns
  Disagreement disagreement = Disagreement::none;
  std::string words;  ///< what is wrong and what to do, for a person; empty: they agree
};

/// `model`: of the plan that is in force without the measurement (slope_operator); it must have a
/// column for each measured mode, those without one are left out.
MatrixComparison compare(const InteractionMatrix& measured, const ModeOperator& model);

}  // namespace ovws
