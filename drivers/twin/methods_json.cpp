#include "drivers/twin/methods_json.hpp"

#include "proto/tables/camera.hpp"

namespace ovws::twin {
namespace {

const std::vector<std::string> kNoises{"fresh", "pool", "none"};

Json json_of(const CameraGeometry& geometry) {
  return {{"rotation_deg", geometry.rotation_deg},
          {"mirror", mirror_names()[std::size_t(geometry.mirror)]},
          {"magnification", geometry.magnification},
          {"centre_px", {geometry.centre_px.x, geometry.centre_px.y}}};
}

Json json_of(const std::optional<TurbulenceConfig>& turbulence) {
  if (!turbulence) return nullptr;
  Json layers = Json::array(), vibrations = Json::array();
  for (const AirLayer& layer : turbulence->layers) {
    layers.push_back({{"strength", layer.strength},
                      {"speed_pupils_per_s", layer.speed_pupils_per_s},
                      {"direction_deg", layer.direction_deg}});
  }
  for (const Vibration& vibration : turbulence->vibrations) {
    vibrations.push_back({{"j", vibration.j},
                          {"rms_waves", vibration.rms_waves},
                          {"frequency_hz", vibration.frequency_hz}});
  }
  return {{"rms_waves", turbulence->rms_waves},
          {"speed_pupils_per_s", turbulence->speed_pupils_per_s},
          {"direction_deg", turbulence->direction_deg},
          {"outer_scale_pupils", turbulence->outer_scale_pupils},
          {"seed", turbulence->seed},
          {"tilt", turbulence->tilt},
          {"layers", layers},
          {"vibrations", vibrations}};
}

Json json_of(const std::optional<ScintillationConfig>& scintillation) {
  if (!scintillation) return nullptr;
  return {{"variance", scintillation->variance},
          {"scale_pupils", scintillation->scale_pupils},
          {"seed", scintillation->seed}};
}

Json json_of(const std::vector<Mode>& aberration) {
  Json modes = Json::array();
  for (const Mode& mode : aberration) {
    const ZernikeIndex index = zernike_index(mode.j);
    modes.push_back({{"j", mode.j}, {"n", index.n}, {"m", index.m}, {"waves", mode.waves}});
  }
  return modes;
}

Json json_of(const std::vector<LightVortex>& branch_points) {
  Json json = Json::array();
  for (const LightVortex& one : branch_points) {
    json.push_back({{"x", one.at.x}, {"y", one.at.y}, {"charge", one.charge}});
  }
  return json;
}

Json json_of(const std::vector<LightSource>& sources) {
  Json json = Json::array();
  for (const LightSource& one : sources) {
    json.push_back({{"offset_px", {one.offset_px.x, one.offset_px.y}},
                    {"power", one.power},
                    {"aberration", json_of(one.aberration)},
                    {"norm", "rms"}});
  }
  return json;
}

Json json_of(const std::vector<Shade>& shades) {
  Json json = Json::array();
  for (const Shade& shade : shades) {
    json.push_back({{"x_px", shade.centre_px.x},
                    {"y_px", shade.centre_px.y},
                    {"radius_px", shade.radius_px},
                    {"transmission", shade.transmission}});
  }
  return json;
}

}  // namespace

const std::vector<std::string>& fault_names() {
  static const std::vector<std::string> names{"none",      "drop",    "incomplete",
                                              "delay",     "freeze",  "unplug",
                                              "duplicate", "reorder", "slow_registers"};
  return names;
}

Json json_of(const Fault& fault) {
  Json json{{"kind", fault_names()[std::size_t(fault.kind)]}};
  if (fault.frames > 0) json["frames"] = fault.frames;
  if (fault.kind != FaultKind::none && fault.frames == 0) json["seconds"] = fault.seconds;
  if (takes_delay(fault.kind)) json["delay_ms"] = fault.delay_ms;
  return json;
}

Json json_of(const MirrorConfig& mirror, const std::vector<Vec2>& actuators,
             const std::vector<double>& waves) {
  Json positions = Json::array();
  for (const Vec2& at : actuators) positions.push_back({at.x, at.y});
  return {{"actuators_across", mirror.actuators_across},
          {"coupling", mirror.coupling},
          {"actuators", actuators.size()},
          {"positions", positions},
          {"waves", waves.empty() ? std::vector<double>(actuators.size()) : waves}};
}

Json json_of(const std::vector<FrameTruth>& frames) {
  Json json = Json::array();
  for (const FrameTruth& frame : frames) {
    json.push_back({{"frame_id", frame.frame_id},
                    {"t_ns", frame.t_ns},
                    {"crc32", frame.crc32},
                    {"slot", frame.pattern ? Json(*frame.pattern) : Json(nullptr)},
                    {"modes", frame.turbulence}});
  }
  return json;
}

Json waves_of(const std::vector<Mode>& modes) {
  Json waves = Json::array();
  for (const Mode& mode : modes) waves.push_back(mode.waves);
  return waves;
}

Json json_of(const std::optional<Verdict>& verdict) {
  if (!verdict) return {{"unwrapped", false}};
  return {{"unwrapped", true},
          {"modes", waves_of(verdict->modes)},
          {"rms_waves", verdict->rms_waves},
          {"rms_with_tilt_waves", verdict->rms_with_tilt_waves},
          {"strehl", verdict->strehl},
          {"strehl_with_tilt", verdict->strehl_with_tilt},
          {"first_order", verdict->first_order}};
}

Json json_of(const CameraStatus& camera) {
  Json json = to_json(camera.settings);
  json.erase("gain_raw");
  json["plugged"] = camera.plugged;
  json["streaming"] = camera.streaming;
  return json;
}

Json json_of(const FrameTally& tally, const FrameCounts& frames) {
  return {{"sent", tally.sent.load()},
          {"dropped", tally.dropped.load()},
          {"incomplete", tally.incomplete.load()},
          {"duplicated", tally.duplicated.load()},
          {"reordered", tally.reordered.load()},
          {"late", tally.late.load()},
          {"refused", tally.refused.load()},
          {"nudges", tally.nudges.load()},
          {"fresh", frames.fresh},
          {"reused", frames.reused}};
}

Json json_of(const OpticalModel& optics, const Truth& truth) {
  const DetectorConfig& d = truth.detector;
  return {{"aberration", json_of(truth.aberration)},
          {"norm", "rms"},
          {"shades", json_of(truth.shades)},
          {"branch_points", json_of(truth.branch_points)},
          {"sources", json_of(truth.sources)},
          {"peak_electrons", truth.peak_electrons},
          {"geometry", json_of(truth.geometry)},
          {"turbulence", json_of(truth.turbulence)},
          {"scintillation", json_of(truth.scintillation)},
          {"photons", optics.photons_per_spot(truth)},
          {"quantum_efficiency", d.quantum_efficiency},
          {"prnu", d.prnu},
          {"shot_noise", d.shot_noise},
          {"dark_current_e_per_s", d.dark_current_e_per_s},
          {"read_noise_e", d.read_noise_e},
          {"full_well_e", d.full_well_e},
          {"black_level_dn", d.black_level_dn},
          {"bits", truth.bits},
          {"left_justified", truth.left_justified},
          {"noise", kNoises[std::size_t(truth.noise)]}};
}

}  // namespace ovws::twin
