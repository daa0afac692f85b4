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

/// The plans of one recording, made on request. One thread at a time.
class RecordedPlans {
 public:
  /// Errc::invalid: a document does not match its checksum, or a plan has no number.
  static Result<RecordedPlans> of(RecordingReader& reader);

  /// Makes the plan of that number. Errors: Errc::invalid if there is none, or its parts are
  /// inconsistent; Errc::refused if an older version measured in a way that this one does not have.
  Result<std::unique_ptr<MeasurementPlan>> make(std::uint64_t plan_id);

 private:
  Result<std::unique_ptr<MeasurementPlan>> read(const nlohmann::json& from);
  Result<void> read_templates(const nlohmann::json& from, MeasurementPlan& plan);

  std::map<std::uint64_t, std::string> plans_;    ///< text by number
  std::map<std::string, std::string> documents_;  ///< text by checksum
  PointReader points_;
  std::shared_ptr<const FrameFit> fit_;  ///< the templates rendered last
  std::string fit_key_;                  ///< checksum of its operating point
  std::string fit_calibration_;          ///< checksum of the calibration that was active then
  Roi fit_roi_;
};

}  // namespace ovws
