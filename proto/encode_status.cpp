/// The rare messages: refined, status and event.
#include <cmath>

#include "proto/encode.hpp"
#include "proto/names.hpp"
#include "proto/results.hpp"

namespace ovws {
namespace {

using nlohmann::json;

std::string text_of(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

json or_null(const std::optional<std::string>& text) {
  return text ? json(*text) : json(nullptr);
}

json or_null(double number) {
  return std::isnan(number) ? json() : json(number);
}

json camera_part(const StatusMessage::CameraPart& camera) {
  return {{"connected", camera.connected},
          {"streaming", camera.streaming},
          {"info", camera.info ? to_json(*camera.info) : json(nullptr)},
          {"settings", to_json(camera.settings)},
          {"fault", or_null(camera.fault)}};
}

json slm_part(const StatusMessage::SlmPart& slm) {
  json info = nullptr;
  if (slm.info) {
    info = {{"output", slm.info->output},
            {"driver", slm.info->driver},
            {"width", slm.info->width},
            {"height", slm.info->height},
            {"refresh_hz", slm.info->refresh_hz}};
  }
  return {{"connected", slm.connected}, {"info", info},
          {"pattern", slm.pattern},     {"hologram_id", slm.hologram_id},
          {"settled", slm.settled},     {"fault", or_null(slm.fault)}};
}

json sensor_part(const StatusMessage::SensorPart& sensor) {
  json out = to_json(sensor.config);
  out["tracker"] = tracker_name(sensor.tracking.tracker);
  out["template"] = template_name(sensor.tracking.templates);
  put(out, sensor.templates);
  out["operator"] = operator_name(sensor.tracking.mode_operator);
  put(out, sensor.mode_operator);
  out["subapertures"] = sensor.subapertures;
  out["modes"] = sensor.modes;
  out["referenced"] = sensor.referenced;
  out["reference"] = sensor.reference;
  out["reference_introduced_rms_waves"] = sensor.reference_introduced_rms_waves;
  out["layout_fault"] = sensor.layout_fault.empty() ? json() : json(sensor.layout_fault);
  out["torn"] = sensor.torn;
  out["invalid"] = nullptr;
  if (const auto& invalid = sensor.invalid) {
    out["invalid"] = {{"t_since_ns", invalid->t_since_ns},
                      {"reason", invalid->reason},
                      {"action", invalid->action},
                      {"searches", invalid->searches},
                      {"t_next_search_ns",
                       invalid->t_next_search_ns ? json(*invalid->t_next_search_ns) : json()}};
  }
  return out;
}

json refine_part(const StatusMessage::RefinePart& refine) {
  return {{"state", refine.state},
          {"done", refine.done},
          {"refused", refine.refused},
          {"last_duration_ms", refine.last_duration_ms ? json(*refine.last_duration_ms) : json()},
          {"reason", or_null(refine.reason)}};
}

/// Root sum square without piston and tilts.
double rms_waves(const RefinedMessage& message) {
  double squares = 0.0;
  for (std::size_t k = 0; k < message.j.size(); ++k) {
    if (message.j[k] > 2) squares += message.coefficients[k] * message.coefficients[k];
  }
  return std::sqrt(squares);
}

json failed_job_part(const std::optional<StatusMessage::FailedJob>& failed) {
  if (!failed) return nullptr;
  return {{"job", failed->job},
          {"kind", failed->kind},
          {"field", failed->field},
          {"reason", failed->reason},
          {"t_failed_ns", failed->t_failed_ns},
          {"t_failed", utc_text(failed->t_failed_ns)}};
}

json latency_part(const LatencySummary& latency) {
  return {{"count", latency.count},
          {"p50_us", latency.p50_us},
          {"p99_us", latency.p99_us},
          {"p999_us", latency.p999_us},
          {"max_us", latency.max_us},
          {"since_start",
           {{"count", latency.since_start.count},
            {"sum_us", latency.since_start.sum_us},
            {"edges_us", LatencyTotals::edges_us()},
            {"below", latency.since_start.below}}}};
}

std::string_view severity_name(Severity severity) {
  switch (severity) {
    case Severity::info:
      return "info";
    case Severity::warning:
      return "warning";
    case Severity::error:
      return "error";
  }
  return "error";
}

}  // namespace

json status_body(const StatusMessage& message) {
  json out{{"t_ns", message.t_ns},
           {"uptime_s", message.uptime_s},
           {"state", message.state},
           {"fault", or_null(message.fault)},
           {"camera", camera_part(message.camera)},
           {"slm", slm_part(message.slm)},
           {"sensor", sensor_part(message.sensor)},
           {"refine", refine_part(message.refine)},
           {"record", record_result(message.record)},
           {"store",
            {{"directory", or_null(message.store.directory)},
             {"reason", or_null(message.store.reason)}}},
           {"loop", message.loop_closed ? "closed" : "open"},
           {"failed_job", failed_job_part(message.failed_job)},
           {"rates",
            {{"grabbed_hz", message.rates.grabbed_hz},
             {"published_hz", message.rates.published_hz},
             {"images_hz", message.rates.images_hz}}},
           {"counters", json::object()},
           {"latency", json::object()},
           {"versions", json::object()}};
  for (const auto& [name, count] : message.counters) out["counters"][name] = count;
  for (const auto& [stage, latency] : message.latency)
    out["latency"][stage] = latency_part(latency);
  for (const auto& [name, version] : message.versions) out["versions"][name] = version;
  return out;
}

std::string encode(const RefinedMessage& message) {
  const json unknown = std::vector<json>(message.j.size());
  const auto& fit = message.fit;
  return text_of({{"schema", "ovws.refined/1"},
                  {"seq", message.seq},
                  {"frame_id", message.frame_id},
                  {"t_arrival_ns", message.t_arrival_ns},
                  {"t_publish_ns", message.t_publish_ns},
                  {"hologram_id", message.hologram_id},
                  {"charge", message.charge},
                  {"valid", message.valid},
                  {"reason", message.valid ? json() : json(message.reason)},
                  {"against", message.against_reference ? "reference" : "model"},
                  {"unit", "wave"},
                  {"wavelength_nm", message.wavelength_nm},
                  {"basis", "zernike-osa-rms"},
                  {"orientation", "x-right-y-down"},
                  {"rms_waves", message.valid ? json(rms_waves(message)) : json()},
                  {"gain_db", or_null(message.gain_db)},
                  {"gain_raw", or_null(message.gain_raw)},
                  {"exposure_us", message.exposure_us},
                  {"j", message.j},
                  {"coefficients", message.valid ? json(message.coefficients) : unknown},
                  {"sigma", message.valid ? json(message.sigma) : unknown},
                  {"chi2_per_pixel", fit ? json(fit->chi2_per_pixel) : json()},
                  {"peak_e", fit ? json(fit->peak_e) : json()},
                  {"background_e", fit ? json(fit->background_e) : json()},
                  {"iterations", fit ? json(fit->iterations) : json()},
                  {"duration_ms", message.duration_ms}});
}

std::string encode(const StatusMessage& message) {
  json out = status_body(message);
  out["schema"] = "ovws.status/1";
  out["seq"] = message.seq;
  return text_of(out);
}

std::string encode(const EventMessage& message, const json& data) {
  return text_of({{"schema", "ovws.event/1"},
                  {"seq", message.seq},
                  {"t_ns", message.t_ns},
                  {"kind", message.kind},
                  {"severity", severity_name(message.severity)},
                  {"text", message.text},
                  {"data", data}});
}

}  // namespace ovws
