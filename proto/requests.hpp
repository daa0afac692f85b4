/// Typed decoding of each method's params: strict, and all or nothing.
///
/// Every error is Errc::invalid with the dotted path of the key at fault. Ranges are those of
/// limits.hpp; with `"clamp": true` a number out of range becomes the nearest limit instead.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/control/integrator.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/tracker.hpp"
#include "proto/refine_setup.hpp"
#include "proto/tables/record.hpp"

namespace ovws {

/// `camera.set`: what is absent stays as it is. The device's own limits are the daemon's to check.
struct CameraSet {
  std::optional<double> gain_db, exposure_us, frame_rate_hz;
  std::optional<double> gain_raw;  ///< not together with gain_db
  std::optional<PixelFormat> pixel_format;
  struct {
    std::optional<int> x, y, width, height;
  } roi;
  bool clamp = false;

  CameraSettings applied_to(CameraSettings settings) const;
};

/// `sensor.set`: what is absent stays as it is.
struct SensorSet {
  std::optional<int> charge;
  std::optional<Grid> grid;
  std::optional<int> subapertures_across;
  std::optional<double> pupil_diameter_px;
  std::optional<std::array<double, 2>> grooves;
  std::optional<double> spacing;
  std::optional<TrackerKind> tracker;
  std::optional<TemplateKind> templates;      ///< key "template"
  std::optional<OperatorKind> mode_operator;  ///< key "operator"
  bool clamp = false;

  SensorConfig applied_to(SensorConfig sensor) const;
  TrackingSettings applied_to(TrackingSettings tracking) const;
};

/// `refine.set`: what is absent stays as it is. A number that may be null is null if it holds none.
struct RefineSet {
  std::optional<bool> enabled;
  std::optional<double> rate_hz;
  std::optional<std::optional<double>> electrons_per_dn;
  std::optional<double> read_noise_e;
  std::optional<double> black_level_dn;
  std::optional<std::optional<double>> saturation_dn;
  std::optional<bool> spot_amplitudes;
  bool clamp = false;  ///< saturation_dn to the format's full scale, too

  RefineSetup applied_to(RefineSetup settings) const;
};

/// `calibration.run`.
struct CalibrationRun {
  double amplitude_waves = 0.15;            ///< RMS-normalised
  int frames = 20;                          ///< averaged for each picture
  std::optional<std::vector<int>> modes_j;  ///< key "modes": OSA indices; none: all
};

Result<CameraSet> decode_camera_set(const nlohmann::json& params);
Result<SensorSet> decode_sensor_set(const nlohmann::json& params);
Result<RefineSet> decode_refine_set(const nlohmann::json& params);
/// `aberration.set`: the modes in RMS normalisation whatever `norm` was, in the order given; no
/// mode twice.
Result<std::vector<Mode>> decode_aberration_set(const nlohmann::json& params);
/// `reference.take`.
struct ReferenceTake {
  int frames = 100;               ///< how many to average
  bool allow_aberration = false;  ///< take it under an introduced aberration, too
};
Result<ReferenceTake> decode_reference_take(const nlohmann::json& params);
/// `lut.run`.
struct LutRun {
  int levels = 33;  ///< grey levels that are measured, from 0 to 255
  int frames = 3;   ///< of each picture
};
Result<LutRun> decode_lut_run(const nlohmann::json& params);
/// `flatness.run`: how many settled frames to average for each place.
Result<int> decode_flatness_run(const nlohmann::json& params);
/// `slm.settle`.
struct SettleRun {
  int repetitions = 20;     ///< changes of the picture
  double watch_ms = 200.0;  ///< after each of them
};
Result<SettleRun> decode_slm_settle(const nlohmann::json& params);
/// `registration.run`: how many frames to average for each picture.
Result<int> decode_registration_run(const nlohmann::json& params);
/// `reference.set`: what positions count from, of which only "model" can be set.
Result<void> decode_reference_set(const nlohmann::json& params);
/// No mode twice.
Result<CalibrationRun> decode_calibration_run(const nlohmann::json& params);
Result<HologramKind> decode_slm_show(const nlohmann::json& params);
/// `loop.close`; the limits of single numbers only, see check_loop.
Result<LoopSettings> decode_loop_close(const nlohmann::json& params);
/// `loop.open`: whether the correction is kept.
Result<bool> decode_loop_open(const nlohmann::json& params);
Result<RecordStart> decode_record_start(const nlohmann::json& params);
/// `job.get` and `job.cancel`: the job's number.
Result<int> decode_job(const nlohmann::json& params);
/// Methods that take no params: an error for any key.
Result<void> decode_nothing(const nlohmann::json& params);

}  // namespace ovws
