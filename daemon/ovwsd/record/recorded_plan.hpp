/// Rebuilds measurement plans from the documents of a recording.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/record/point_document.hpp"
#include "drivers/replay/recording_reader.hpp"

namespace ovws {

/// Measurement plans of one recording, made on request. Used by one thread at a time.
class RecordedPlans {
 public:
  /// Reads the plans of a recording. Errc::invalid: a document does not match its checksum, or a
  /// plan has no number.
  static Result<RecordedPlans> of(RecordingReader& reader);

  /// Makes the plan with number `plan_id`. Errc::invalid: there is no such plan, or its parts are
  /// inconsistent. Errc::refused: an older version measured by a method that this version lacks.
  Result<std::unique_ptr<MeasurementPlan>> make(std::uint64_t plan_id);

 private:
  Result<std::unique_ptr<MeasurementPlan>> read(const nlohmann::json& from);
  Result<void> read_templates(const nlohmann::json& from, MeasurementPlan& plan);

  std::map<std::uint64_t, std::string> plans_;    ///< plan texts by plan number
  std::map<std::string, std::string> documents_;  ///< document texts by checksum
  PointReader points_;
  std::shared_ptr<const FrameFit> fit_;  ///< the templates rendered last
  std::string fit_key_;                  ///< checksum of the operating point of fit_
  std::string fit_calibration_;  ///< checksum of the calibration that fit_ needs; empty: none
  Roi fit_roi_;
  LitPixels fit_lit_;
};

}  // namespace ovws
