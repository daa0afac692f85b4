/// Rebuilds measurement plans from the documents of a recording.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/record/point_document.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"
#include "drivers/replay/recording_reader.hpp"

namespace ovws {

/// Measurement plans of one recording, made on request. Used by one thread at a time.
class RecordedPlans {
 public:
  /// Reads the plans of a recording. Errc::invalid: a document does not match its checksum, or a
  /// plan has no number.
  static Result<RecordedPlans> of(RecordingReader& reader);

  /// Makes the plan with number `plan_id`. Errc::invalid: there is no such plan, or its parts are
  /// inconsistent. Errc::refused: it was measured by a method that this program lacks.
  Result<std::unique_ptr<MeasurementPlan>> make(std::uint64_t plan_id);

  /// The configuration of the daemon when the recording began. Errc::invalid, field "path": it is
  /// missing, or this version cannot read it.
  Result<Config> configuration() const;
  /// The sensor of a plan that `make` has made, as far as refinement needs it: its settings, modes
  /// and reference. Keeps the last one. Errors: those of `configuration`; Errc::invalid: a document
  /// is missing or its parts are inconsistent.
  Result<SensorView> sensor(std::uint64_t plan_id, const MeasurementPlan& plan);

 private:
  Result<SensorView> read_sensor(const nlohmann::json& from, const MeasurementPlan& plan);
  Result<std::shared_ptr<const Reference>> read_reference(const std::string& sha256);

  Result<std::unique_ptr<MeasurementPlan>> read(const nlohmann::json& from);
  Result<std::unique_ptr<MeasurementPlan>> read_source(const nlohmann::json& from);
  Result<void> read_operator(const nlohmann::json& from, MeasurementPlan& plan);
  Result<void> read_beams(const nlohmann::json& from, MeasurementPlan& plan);
  Result<std::shared_ptr<const BranchPoints>> read_branch_points(const nlohmann::json& from,
                                                                 std::size_t spots) const;
  Result<void> read_templates(const nlohmann::json& from, MeasurementPlan& plan);

  std::map<std::uint64_t, std::string> plans_;    ///< plan texts by plan number
  std::map<std::string, std::string> documents_;  ///< document texts by checksum
  std::optional<Result<Config>> configuration_;   ///< as parsed; none: there is no document
  PointReader points_;
  std::shared_ptr<const FrameFit> fit_;  ///< the templates rendered last
  std::string fit_key_;                  ///< checksum of the operating point of fit_
  std::string fit_calibration_;  ///< checksum of the calibration that fit_ needs; empty: none
  Roi fit_roi_;
  LitPixels fit_lit_;
  std::uint64_t sensor_plan_ = 0;  ///< plan of sensor_
  SensorView sensor_;
  std::string reference_sha256_;  ///< of reference_
  std::shared_ptr<const Reference> reference_;
};

}  // namespace ovws
