/// From Config to text, keys in the order of ovwsd.json.
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/config.hpp"
#include "proto/names.hpp"

namespace ovws {
namespace {

using nlohmann::ordered_json;

ordered_json or_null(const std::optional<std::string>& text) {
  return text ? ordered_json(*text) : ordered_json(nullptr);
}

ordered_json camera_json(const CameraConfig& camera) {
  const CameraSettings& settings = camera.settings;
  return {{"driver", camera.driver},
          {"id", camera.id},
          {"pixel_format", pixel_format_name(settings.pixel_format)},
          {"exposure_us", settings.exposure_us},
          // Of a camera without gain in dB: the value that asks for nothing.
          {"gain_db", std::isnan(settings.gain_db) ? 0.0 : settings.gain_db},
          {"gain_raw",
           std::isnan(settings.gain_raw) ? ordered_json() : ordered_json(settings.gain_raw)},
          {"frame_rate_hz", settings.frame_rate_hz},
          {"roi",
           {{"x", settings.roi.x},
            {"y", settings.roi.y},
            {"width", settings.roi.width},
            {"height", settings.roi.height}}},
          {"packet_size_bytes", camera.packet_size_bytes},
          {"transfer_ms", camera.transfer_ms}};
}

ordered_json slm_json(const SlmConfig& slm) {
  return {{"driver", slm.driver},
          {"display", slm.display},
          {"width", slm.geometry.width_px},
          {"height", slm.geometry.height_px},
          {"pitch_um", slm.geometry.pitch_um},
          {"lut", or_null(slm.lut)},
          {"flatness", or_null(slm.flatness)},
          {"settle_ms", slm.settle_ms},
          {"allow_primary", slm.allow_primary}};
}

ordered_json optics_json(const OpticsConfig& optics) {
  ordered_json centre = nullptr;
  if (optics.centre_px) centre = {optics.centre_px->x, optics.centre_px->y};
  ordered_json matrix = nullptr;
  if (const auto& m = optics.registered) matrix = {m->xx, m->xy, m->yx, m->yy};
  return {{"wavelength_nm", optics.wavelength_nm},
          {"focal_length_mm", optics.focal_length_mm},
          {"magnification", optics.magnification},
          {"camera_pitch_um", optics.camera_pitch_um},
          {"centre_px", centre},
          {"px_per_cycle", matrix}};
}

ordered_json sensor_json(const SensorConfig& sensor) {
  return {{"charge", sensor.charge},
          {"grid", grid_name(sensor.grid)},
          {"subapertures_across", sensor.subapertures_across},
          {"pupil_diameter_px", sensor.pupil_diameter_px},
          {"grooves", sensor.grooves},
          {"spacing", sensor.spacing}};
}

ordered_json refine_json(const RefineSetup& refine) {
  const auto number_or_null = [](const std::optional<double>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
  };
  return {{"enabled", refine.enabled},
          {"rate_hz", refine.rate_hz},
          {"electrons_per_dn", number_or_null(refine.electrons_per_dn)},
          {"read_noise_e", refine.read_noise_e},
          {"black_level_dn", refine.black_level_dn},
          {"saturation_dn", number_or_null(refine.saturation_dn)},
          {"spot_amplitudes", refine.spot_amplitudes}};
}

}  // namespace

std::string dump_config(const Config& config) {
  ordered_json out;
  out["camera"] = camera_json(config.camera);
  out["slm"] = slm_json(config.slm);
  out["optics"] = optics_json(config.optics);
  out["sensor"] = sensor_json(config.sensor);
  out["tracking"] = {{"tracker", tracker_name(config.tracking.tracker)},
                     {"template", template_name(config.tracking.templates)},
                     {"operator", operator_name(config.tracking.mode_operator)},
                     {"kernel_radius", config.tracking.kernel_radius}};
  out["refine"] = refine_json(config.refine);
  out["stream"] = {{"endpoint", config.stream.endpoint},
                   {"image_endpoint", config.stream.image_endpoint},
                   {"image_rate_hz", config.stream.image_rate_hz}};
  out["control"] = {{"endpoint", config.control.endpoint}};
  out["security"] = {{"secret_key", or_null(config.security.secret_key)},
                     {"clients", or_null(config.security.clients)}};
  out["state"] = {{"directory", or_null(config.state.directory)}};
  out["record"] = {{"directory", or_null(config.record.directory)},
                   {"buffer_mib", config.record.buffer_mib}};
  out["realtime"] = config.realtime == RealtimePolicy::enforce ? "enforce" : "ignore";
  out["pipeline"] = {{"workers", config.pipeline.workers},
                     {"records", config.pipeline.records},
                     {"cpus", config.frame_path_cpus}};
  out["log"] = {{"level", config.log.level}};
  return out.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace ovws
