#include "proto/results.hpp"

#include <array>
#include <cmath>
#include <ctime>

#include "proto/names.hpp"
#include "proto/rpc.hpp"

namespace ovws {
namespace {

using nlohmann::json;

template <class T>
json range(const Range<T>& r) {
  return {{"min", r.min}, {"max", r.max}, {"increment", r.increment}};
}

json or_null(double number) {
  return std::isnan(number) ? json() : json(number);
}

/// The params of a set without what only says how to set.
json requested(json params) {
  params.erase("clamp");
  return params;
}

json points(std::span<const Vec2> all) {
  json out = json::array();
  for (const Vec2& point : all) out.push_back({point.x, point.y});
  return out;
}

json sensor_settings(const SensorReport& report) {
  json out = to_json(report.config);
  out["tracker"] = tracker_name(report.tracking.tracker);
  out["template"] = template_name(report.tracking.templates);
  out["operator"] = operator_name(report.tracking.mode_operator);
  return out;
}

std::string_view state_name(JobState state) {
  constexpr std::array<std::string_view, 4> kNames{"running", "done", "failed", "cancelled"};
  return kNames[std::size_t(state)];
}

}  // namespace

json to_json(const Roi& roi) {
  return {{"x", roi.x}, {"y", roi.y}, {"width", roi.width}, {"height", roi.height}};
}

json to_json(const CameraSettings& settings) {
  return {{"gain_db", or_null(settings.gain_db)},
          {"gain_raw", or_null(settings.gain_raw)},
          {"exposure_us", settings.exposure_us},
          {"frame_rate_hz", settings.frame_rate_hz},
          {"pixel_format", pixel_format_name(settings.pixel_format)},
          {"roi", to_json(settings.roi)}};
}

json to_json(const CameraLimits& limits) {
  json formats = json::array();
  for (const PixelFormat format : limits.pixel_formats)
    formats.push_back(pixel_format_name(format));
  return {{"gain_db", limits.gain_raw ? json() : range(limits.gain_db)},
          {"gain_raw", limits.gain_raw ? range(*limits.gain_raw) : json()},
          {"exposure_us", range(limits.exposure_us)},
          {"frame_rate_hz", range(limits.frame_rate_hz)},
          {"roi_width", range(limits.roi_width)},
          {"roi_height", range(limits.roi_height)},
          {"sensor_width", limits.sensor_width},
          {"sensor_height", limits.sensor_height},
          {"pixel_formats", formats}};
}

json to_json(const CameraInfo& info) {
  return {{"vendor", info.vendor},
          {"model", info.model},
          {"serial", info.serial},
          {"address", info.address}};
}

json to_json(const SensorConfig& sensor) {
  return {{"charge", sensor.charge},
          {"grid", grid_name(sensor.grid)},
          {"subapertures_across", sensor.subapertures_across},
          {"pupil_diameter_px", sensor.pupil_diameter_px},
          {"grooves", sensor.grooves},
          {"spacing", sensor.spacing}};
}

json camera_get_result(const std::optional<CameraInfo>& info, const CameraSettings& settings,
                       const std::optional<CameraLimits>& limits) {
  return {{"connected", info.has_value()},
          {"info", info ? to_json(*info) : json(nullptr)},
          {"settings", to_json(settings)},
          {"limits", limits ? to_json(*limits) : json(nullptr)}};
}

json camera_set_result(const json& params, const CameraSettings& applied,
                       const std::optional<CameraLimits>& limits) {
  return {{"requested", requested(params)},
          {"applied", to_json(applied)},
          {"limits", limits ? to_json(*limits) : json(nullptr)}};
}

void put(json& out, const TemplateReport& report) {
  out["own_templates"] = report.own;
  out["template_reason"] = report.reason.empty() ? json(nullptr) : json(report.reason);
}

void put(json& out, const OperatorReport& report) {
  out["operator_in_force"] = operator_name(report.in_force);
  out["operator_reason"] = report.reason.empty() ? json(nullptr) : json(report.reason);
}

json sensor_get_result(const SensorReport& report) {
  json out = sensor_settings(report);
  put(out, report.templates);
  put(out, report.mode_operator);
  out["subapertures"] = report.subapertures;
  out["modes_j"] = report.modes_j;
  out["hologram_id"] = report.hologram_id;
  return out;
}

json sensor_set_result(const json& params, const SensorReport& applied) {
  return {{"requested", requested(params)},
          {"applied", sensor_settings(applied)},
          {"hologram_id", applied.hologram_id}};
}

json refine_get_result(const RefineSetup& settings) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? json(*value) : json(nullptr);
  };
  return {{"enabled", settings.enabled},
          {"rate_hz", settings.rate_hz},
          {"electrons_per_dn", or_null(settings.electrons_per_dn)},
          {"read_noise_e", settings.read_noise_e},
          {"black_level_dn", settings.black_level_dn},
          {"saturation_dn", or_null(settings.saturation_dn)},
          {"spot_amplitudes", settings.spot_amplitudes},
          {"pixel_format", pixel_format_name(settings.format)}};
}

json refine_set_result(const json& params, const RefineSetup& applied) {
  return {{"requested", requested(params)}, {"applied", refine_get_result(applied)}};
}

json aberration_result(std::span<const Mode> modes, std::uint64_t hologram_id) {
  json list = json::array();
  for (const Mode& mode : modes) {
    const ZernikeIndex index = zernike_index(mode.j);
    list.push_back({{"j", mode.j},
                    {"n", index.n},
                    {"m", index.m},
                    {"name", zernike_name(mode.j)},
                    {"waves", mode.waves}});
  }
  return {{"modes", list}, {"norm", "rms"}, {"hologram_id", hologram_id}};
}

std::string utc_text(std::int64_t t_ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::time_t seconds = t_ns / kSecond;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &utc);
  const std::string milliseconds = std::to_string(1000 + t_ns % kSecond / 1'000'000);
  return text.data() + ("." + milliseconds.substr(1)) + "Z";
}

json reference_result(const std::optional<ReferenceReport>& reference) {
  if (!reference) {
    json out{{"taken", false}, {"stale", json::array()}};
    for (const char* key :
         {"source", "frames", "charge", "tracker", "t_taken_ns", "t_taken", "positions_px",
          "standard_error_px", "sha256", "origin", "introduced_rms_waves"}) {
      out[key] = nullptr;
    }
    return out;
  }
  json stale = json::array();
  for (const StaleField& one : reference->stale) {
    stale.push_back({{"field", one.field}, {"then", one.then}, {"now", one.now}});
  }
  return {{"taken", true},
          {"source", reference->source},
          {"frames", reference->frames},
          {"charge", reference->charge},
          {"tracker", tracker_name(reference->tracker)},
          {"t_taken_ns", reference->t_taken_ns},
          {"t_taken", utc_text(reference->t_taken_ns)},
          {"positions_px", points(reference->positions_px)},
          {"standard_error_px", points(reference->standard_error_px)},
          {"sha256", reference->sha256.empty() ? json(nullptr) : json(reference->sha256)},
          {"stale", stale},
          {"origin", reference->origin},
          {"introduced_rms_waves", reference->introduced_rms_waves}};
}

json registration_result(const std::optional<Registration>& registration) {
  if (!registration) {
    json none{{"registered", false}};
    for (const char* key : {"t_taken_ns", "base_px", "base_standard_error_px", "px_per_cycle",
                            "px_per_cycle_standard_error", "scale_px_per_cycle", "rotation_deg",
                            "mirrored", "residual_px", "sights"}) {
      none[key] = nullptr;
    }
    return none;
  }
  const auto numbers = [](const PxPerCycle& m) { return json{m.xx, m.xy, m.yx, m.yy}; };
  const Registration& r = *registration;
  return {{"registered", true},
          {"t_taken_ns", r.t_taken_ns},
          {"base_px", {r.base_px.x, r.base_px.y}},
          {"base_standard_error_px", {r.base_standard_error_px.x, r.base_standard_error_px.y}},
          {"px_per_cycle", numbers(r.px_per_cycle)},
          {"px_per_cycle_standard_error", numbers(r.standard_error)},
          {"scale_px_per_cycle", r.px_per_cycle.scale()},
          {"rotation_deg", r.px_per_cycle.rotation_deg()},
          {"mirrored", r.px_per_cycle.mirrored()},
          {"residual_px", r.residual_px},
          {"sights", r.sights}};
}

json loop_result(const LoopReport& report) {
  const LoopSettings& s = report.settings;
  json gains = json::array();
  for (const ModeGain& one : s.gains) gains.push_back({{"j", one.j}, {"gain", one.gain}});
  const auto or_null = [](bool known, json value) { return known ? std::move(value) : json(); };
  const bool was_opened = !report.opened_because.empty();
  return {{"closed", report.closed},
          {"gain", s.gain},
          {"leak", s.leak},
          {"modes", or_null(!s.modes.empty(), s.modes)},
          {"gains", gains},
          {"limit_waves", s.limit_waves},
          {"patience_s", s.patience_s},
          {"steps", report.steps},
          {"residual_rms_waves",
           or_null(report.residual_rms_waves.has_value(), report.residual_rms_waves.value_or(0.0))},
          {"correction_rms_waves", report.correction_rms_waves},
          {"opened_because", or_null(was_opened, report.opened_because)},
          {"t_opened_ns", or_null(was_opened, report.t_opened_ns)},
          {"t_opened", or_null(was_opened, utc_text(report.t_opened_ns))}};
}

json slm_show_result(HologramKind pattern, std::uint64_t hologram_id) {
  return {{"pattern", pattern_name(pattern)}, {"hologram_id", hologram_id}};
}

json record_result(const RecordReport& report) {
  const auto or_null = [](const std::optional<std::string>& text) {
    return text ? json(*text) : json();
  };
  return {{"state", report.state},
          {"file", or_null(report.file)},
          {"duration_s", report.duration_s},
          {"frames", report.frames},
          {"frames_dropped", report.frames_dropped},
          {"pictures", report.pictures},
          {"pictures_dropped", report.pictures_dropped},
          {"bytes", report.bytes},
          {"reason", or_null(report.reason)}};
}

json to_json(const JobReport& job) {
  json error = nullptr;
  if (job.error) {
    const RpcFailure failure = rpc_failure(*job.error);
    error = {{"code", int(failure.code)}, {"message", failure.message}, {"data", failure.data}};
  }
  return {{"job", job.job},           {"kind", job.kind},     {"state", state_name(job.state)},
          {"progress", job.progress}, {"result", job.result}, {"error", error}};
}

json job_started_result(int job) {
  return {{"job", job}};
}

}  // namespace ovws
