/// Typed encoding of what calibration.* answers; the shapes are those of the JSON Schemas.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/wavefront/interaction_matrix.hpp"
#include "core/wavefront/matrix_comparison.hpp"

namespace ovws {

/// "sign", "axes", …; in the order of the enumeration, "none" first.
std::string_view disagreement_name(Disagreement disagreement);

struct CalibrationReport {
  bool in_force = false;
  double amplitude_waves = 0.0;  ///< asked for
  int frames = 0;
  std::int64_t t_taken_ns = 0;
  const InteractionMatrix& matrix;
  const MatrixComparison& comparison;
  std::string sha256;     ///< of the file that keeps it; empty: it is not kept
  nlohmann::json origin;  ///< what it was measured with; as in the schema
};

/// `calibration.get` and `.clear`, and the result of the job of `calibration.run`.
nlohmann::json calibration_result(const std::optional<CalibrationReport>& calibration);

}  // namespace ovws
