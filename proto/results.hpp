/// Typed encoding of what methods answer; the shapes are those of the JSON Schemas.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/control/integrator.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/registration.hpp"
#include "proto/refine_setup.hpp"

namespace ovws {

nlohmann::json to_json(const Roi& roi);
nlohmann::json to_json(const CameraSettings& settings);
nlohmann::json to_json(const CameraLimits& limits);
nlohmann::json to_json(const CameraInfo& info);
nlohmann::json to_json(const SensorConfig& sensor);

/// `camera.get`; `info` and `limits` are none while no camera is connected.
nlohmann::json camera_get_result(const std::optional<CameraInfo>& info,
                                 const CameraSettings& settings,
                                 const std::optional<CameraLimits>& limits);
/// `camera.set`: `params` as received; `applied` holds every setting as read back; `limits` none
/// while no camera is connected (the settings are then applied when it is).
nlohmann::json camera_set_result(const nlohmann::json& params, const CameraSettings& applied,
                                 const std::optional<CameraLimits>& limits);

/// What of `template` is in use: a reference may hold less than was asked for.
struct TemplateReport {
  int own = 0;         ///< spots whose template is their own of the reference, not the model's
  std::string reason;  ///< why not all though that was asked for, for a person; empty: no such case
};
void put(nlohmann::json& out, const TemplateReport& report);

/// What turns displacements into modes now: the operator asked for may not be there yet.
struct OperatorReport {
  OperatorKind in_force = OperatorKind::slopes;
  std::string reason;  ///< why it is not the one asked for, for a person; empty: it is
};
void put(nlohmann::json& out, const OperatorReport& report);

struct SensorReport {
  SensorConfig config;
  TrackingSettings tracking;
  TemplateReport templates;
  OperatorReport mode_operator;
  int subapertures = 0;
  std::vector<int> modes_j;
  std::uint64_t hologram_id = 0;
};
nlohmann::json sensor_get_result(const SensorReport& report);
nlohmann::json sensor_set_result(const nlohmann::json& params, const SensorReport& applied);

/// `refine.get`: the numbers are in DN of the settings' own format, which is stated with them.
nlohmann::json refine_get_result(const RefineSetup& settings);
nlohmann::json refine_set_result(const nlohmann::json& params, const RefineSetup& applied);

/// `aberration.get`, `.set` and `.clear`: RMS-normalised waves.
nlohmann::json aberration_result(std::span<const Mode> modes, std::uint64_t hologram_id);

/// "2026-01-31T12:00:00.000Z"
std::string utc_text(std::int64_t t_ns);

/// A setting that is not what it was when the reference was taken.
struct StaleField {
  std::string field;
  nlohmann::json then, now;
};

/// `reference.get`.
struct ReferenceReport {
  int frames = 0;
  int charge = 1;
  TrackerKind tracker = TrackerKind::lg;
  std::int64_t t_taken_ns = 0;
  std::vector<Vec2> positions_px;        ///< camera pixels of the ROI, by subaperture
  std::vector<Vec2> standard_error_px;   ///< of positions_px, by x and y
  std::string_view source = "measured";  ///< or "model"
  std::string sha256;                    ///< of the file that keeps it; empty: it is not kept
  std::vector<StaleField> stale;
  nlohmann::json origin;              ///< what it was taken with; as in the schema
  double introduced_rms_waves = 0.0;  ///< aberration that it holds
};
nlohmann::json reference_result(const std::optional<ReferenceReport>& reference);

/// `registration.get` and `.clear`, and the result of the job of `registration.run`.
nlohmann::json registration_result(const std::optional<Registration>& registration);

nlohmann::json slm_show_result(HologramKind pattern, std::uint64_t hologram_id);

/// `loop.close`, `.open` and `.get`.
struct LoopReport {
  bool closed = false;
  LoopSettings settings;  ///< of the present or the last time
  std::int64_t steps = 0;
  std::optional<double> residual_rms_waves;  ///< before the last step, of the corrected modes
  double correction_rms_waves = 0.0;
  std::string opened_because;    ///< empty: it is closed, or never was
  std::int64_t t_opened_ns = 0;  ///< since when that holds; of no meaning if that is empty
};
nlohmann::json loop_result(const LoopReport& report);

/// `record.start`, `.stop` and `.get`, and the `record` part of `status`: of the recording that is
/// on, or of the last one.
struct RecordReport {
  std::string state = "off";        ///< "off": none since the start; "recording", "ended"
  std::optional<std::string> file;  ///< its path
  double duration_s = 0.0;
  std::uint64_t frames = 0, frames_dropped = 0;
  std::uint64_t pictures = 0, pictures_dropped = 0;
  std::uint64_t bytes = 0;            ///< of the file
  std::optional<std::string> reason;  ///< why it ended
};
nlohmann::json record_result(const RecordReport& report);

enum class JobState { running, done, failed, cancelled };
struct JobReport {
  int job = 0;
  std::string kind;  ///< the method that started it
  JobState state = JobState::running;
  double progress = 0.0;       ///< 0..1
  nlohmann::json result;       ///< null unless done
  std::optional<Error> error;  ///< of a failed job
};
nlohmann::json to_json(const JobReport& job);
/// A method that started a job.
nlohmann::json job_started_result(int job);

}  // namespace ovws
