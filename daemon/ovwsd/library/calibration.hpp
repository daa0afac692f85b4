/// Calibration: the measured interaction (poke) matrix, and the bench and settings that it is valid
/// for.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/zernike.hpp"
#include "core/wavefront/interaction_matrix.hpp"
#include "core/wavefront/matrix_comparison.hpp"
#include "daemon/ovwsd/library/bench_key.hpp"

namespace ovws {

/// Result of calibration.run, or a matrix of calibration.set.
struct MeasuredCalibration {
  double amplitude_waves = 0.0;  ///< requested poke; some modes may have been poked by less
  int frames = 0;                ///< number of frames averaged for each hologram
  std::int64_t t_taken_ns = 0;
  InteractionMatrix matrix;
  MatrixComparison comparison;
  std::vector<int> unsteady_j{};  ///< modes whose response differed from poke to poke
  std::shared_ptr<const MeasuredShapes> shapes;  ///< null unless the tracker is `fit`
};

/// Mode operator of kind `measured`, made from the calibration's poke matrix.
ModeOperator mode_operator_of(const MeasuredCalibration& measured);

struct Calibration : MeasuredCalibration {
  BenchKey key;
  ModeOperator mode_operator;
  std::shared_ptr<const nlohmann::json> origin;  ///< see make_origin; never null
  bool drawn_alike = true;                       ///< as in Reference
};

/// What it depends on.
constexpr respect::Set respects_of(const Calibration&) {
  return respect::kCalibration;
}

/// Converts a calibration to the JSON content of its file, and back. The matrix and its standard
/// errors are preserved bit for bit; the comparison with the model is not stored. Errors
/// (Errc::invalid) name the inconsistent field.
nlohmann::json calibration_content(const Calibration& calibration);
Result<Calibration> calibration_from(const nlohmann::json& content);

}  // namespace ovws
