#include "drivers/twin/twin_config.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/optics/lattice.hpp"
#include "proto/limits.hpp"
#include "proto/names.hpp"
#include "proto/requests.hpp"
#include "proto/strict_json.hpp"
#include "proto/tables/optics.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws::twin {
namespace {

constexpr int kMaxConfigDepth = 16;
constexpr std::size_t kMaxLayers = 8, kMaxVibrations = 16;
constexpr double kMaxPupilsPerS = 1000.0;

void read_rotation(ObjectReader& r, CameraGeometry& geometry) {
  int mirror = int(geometry.mirror);
  r.number("rotation_deg", geometry.rotation_deg, -360.0, 360.0);
  r.choice("mirror", mirror, mirror_names());
  geometry.mirror = Mirror(mirror);
}

void read_scale(ObjectReader& r, CameraGeometry& geometry) {
  using namespace limits;
  r.number("magnification", geometry.magnification, kMagnification.min, kMagnification.max);
  std::vector<double> centre{geometry.centre_px.x, geometry.centre_px.y};
  r.numbers("centre_px", centre, 2, 2, kCentrePx.min, kCentrePx.max);
  geometry.centre_px = {centre[0], centre[1]};
}

void read_camera(ObjectReader& r, CameraConfig& camera, CameraGeometry& geometry) {
  read_rotation(r, geometry);
  r.string("address", camera.address);
  r.string("serial", camera.serial);
  if (camera.serial.empty() || camera.serial.size() > 15) {
    r.fault("serial", "must have 1 to 15 characters");
  }
  r.integer("sensor_width", camera.sensor_width, 64, 8192);
  r.integer("sensor_height", camera.sensor_height, 64, 8192);
}

void read_slm(ObjectReader& r, SlmConfig& slm) {
  r.string("display", slm.display);
  detail::decode_fields(r, slm.geometry);
  r.number("gamma", slm.gamma, 0.1, 10.0);
  r.number("depth_waves", slm.depth_waves, -4.0, 4.0);
  r.number("flatness_rms_waves", slm.flatness_rms_waves, 0.0, 10.0);
  r.number("flatness_cycles", slm.flatness_cycles, 0.5, 20.0);
  r.integer("flatness_seed", slm.flatness_seed, 0, 1'000'000);
  r.number("settle_ms", slm.settle_ms, 0.0, 10'000.0);
}

void read_optics(ObjectReader& r, OpticsConfig& optics, CameraGeometry& geometry) {
  read_scale(r, geometry);
  using namespace limits;
  r.number("wavelength_nm", optics.wavelength_nm, kWavelengthNm.min, kWavelengthNm.max);
  r.number("focal_length_mm", optics.focal_length_mm, kFocalLengthMm.min, kFocalLengthMm.max);
  r.number("camera_pitch_um", optics.camera_pitch_um, kCameraPitchUm.min, kCameraPitchUm.max);
}

void read_light(ObjectReader& r, LightConfig& light, Truth& truth) {
  int shape = int(light.shape);
  r.choice("shape", shape, {"uniform", "gaussian"});
  light.shape = LightShape(shape);
  r.number("diameter_px", light.diameter_px, 10.0, 100e3);
  r.number("peak_electrons", truth.peak_electrons, 0.0, 1e9);
}

void read_dmd(ObjectReader& r, PatternMode& dmd) {
  int order = int(dmd.bit_order);
  r.integer("slots", dmd.patterns, 0, 24);
  if (dmd.patterns == 1) r.fault("slots", "must be 0 (video mode) or 2 to 24");
  r.choice("bit_order", order, {"GRB", "RGB", "BGR"});
  r.number("cycle_ms", dmd.cycle_ms, 2.0, 200.0);
  dmd.bit_order = BitOrder(order);
}

void read_mirror(ObjectReader& r, std::optional<MirrorConfig>& mirror) {
  if (!r.has("mirror")) return;
  mirror.reset();
  if (r.is_null("mirror")) return;
  MirrorConfig& m = mirror.emplace();
  r.object("mirror", [&m](ObjectReader& in) {
    in.integer("actuators_across", m.actuators_across, 2, 64);
    in.number("coupling", m.coupling, 0.001, 0.9);
  });
}

void read_config(ObjectReader& r, Config& c) {
  int modulator = int(c.modulator);
  r.choice("modulator", modulator, {"slm", "fixed", "dmd"});
  c.modulator = Modulator(modulator);
  r.object("dmd", [&](ObjectReader& in) { read_dmd(in, c.dmd); });
  if (c.dmd.patterns > 0 && c.modulator != Modulator::dmd) {
    r.fault("dmd.slots", "needs \"modulator\": \"dmd\"");
  }
  r.object("array", [&](ObjectReader& in) { read_array(in, c.array); });
  r.object("camera", [&](ObjectReader& in) { read_camera(in, c.camera, c.truth.geometry); });
  r.object("slm", [&](ObjectReader& in) { read_slm(in, c.slm); });
  r.object("optics", [&](ObjectReader& in) { read_optics(in, c.optics, c.truth.geometry); });
  r.object("sensor", [&](ObjectReader& in) { detail::decode_fields(in, c.sensor); });
  r.object("light", [&](ObjectReader& in) { read_light(in, c.light, c.truth); });
  r.object("detector", [&](ObjectReader& in) { read_detector(in, c.truth); });
  r.object("control", [&](ObjectReader& in) { in.string("endpoint", c.control_endpoint); });
  read_aberration(r, c.truth.aberration);
  read_shades(r, c.truth);
  read_branch_points(r, c.truth);
  read_sources(r, c.truth);
  read_noise(r, c.truth);
  read_turbulence(r, c.truth.turbulence);
  read_scintillation(r, c.truth.scintillation);
  read_mirror(r, c.mirror);
}

}  // namespace

void read_aberration(ObjectReader& r, std::vector<Mode>& aberration) {
  int norm = int(ZernikeNorm::rms);
  r.choice("norm", norm, kNames<ZernikeNorm>());
  const nlohmann::json* modes = r.raw("aberration");
  if (modes == nullptr || r.failed()) return;
  const auto decoded =
      ModesSet::decode({{"modes", *modes}, {"norm", kNames<ZernikeNorm>()[std::size_t(norm)]}});
  if (decoded) {
    aberration = decoded->modes;
    return;
  }
  const std::string within = decoded.error().field.substr(std::string("modes").size());
  r.fault("aberration" + within, decoded.error().reason);
}

void read_sources(ObjectReader& r, Truth& truth) {
  constexpr std::size_t kMaxSources = 8;
  if (!r.has("sources")) return;
  truth.sources.clear();
  r.objects("sources", kMaxSources, [&truth](ObjectReader& in, std::size_t) {
    LightSource source;
    std::vector<double> offset{0.0, 0.0};
    in.require("offset_px");
    in.numbers("offset_px", offset, 2, 2, limits::kCentrePx.min, limits::kCentrePx.max);
    in.number("power", source.power, 0.0, 1000.0);
    read_aberration(in, source.aberration);
    source.offset_px = {offset[0], offset[1]};
    truth.sources.push_back(std::move(source));
  });
}

void read_shades(ObjectReader& r, Truth& truth) {
  constexpr std::size_t kMaxShades = 64;
  if (!r.has("shades")) return;
  truth.shades.clear();
  r.objects("shades", kMaxShades, [&truth](ObjectReader& in, std::size_t) {
    Shade shade;
    in.require("x_px");
    in.require("y_px");
    in.require("radius_px");
    in.number("x_px", shade.centre_px.x, -1e5, 1e5);
    in.number("y_px", shade.centre_px.y, -1e5, 1e5);
    in.number("radius_px", shade.radius_px, 0.0, 1e5);
    in.number("transmission", shade.transmission, 0.0, 1.0);
    truth.shades.push_back(shade);
  });
}

std::complex<float> field_about(const LightVortex& vortex, Vec2 at) {
  constexpr double kCoreRadii = 0.02;
  const Vec2 r = at - vortex.at;
  const double amplitude = std::min(1.0, norm(r) / kCoreRadii);
  return std::complex<float>(std::polar(amplitude, vortex.charge * std::atan2(r.y, r.x)));
}

void read_branch_points(ObjectReader& r, Truth& truth) {
  constexpr std::size_t kMaxBranchPoints = 64;
  if (!r.has("branch_points")) return;
  truth.branch_points.clear();
  r.objects("branch_points", kMaxBranchPoints, [&truth](ObjectReader& in, std::size_t) {
    LightVortex vortex;
    in.require("x");
    in.require("y");
    in.number("x", vortex.at.x, -2.0, 2.0);
    in.number("y", vortex.at.y, -2.0, 2.0);
    in.integer("charge", vortex.charge, -8, 8);
    truth.branch_points.push_back(vortex);
  });
}

void read_detector(ObjectReader& r, Truth& truth) {
  DetectorConfig& d = truth.detector;
  r.number("quantum_efficiency", d.quantum_efficiency, 0.001, 1.0);
  r.number("prnu", d.prnu, 0.0, 0.5);
  r.boolean("shot_noise", d.shot_noise);
  r.number("dark_current_e_per_s", d.dark_current_e_per_s, 0.0, 1e6);
  r.number("read_noise_e", d.read_noise_e, 0.0, 1e5);
  r.number("full_well_e", d.full_well_e, 10.0, 1e7);
  r.number("black_level_dn", d.black_level_dn, 0.0, 1000.0);
  r.integer("bits", truth.bits, 0, 16);
  r.boolean("left_justified", truth.left_justified);
}

void read_noise(ObjectReader& r, Truth& truth) {
  int noise = int(truth.noise);
  r.choice("noise", noise, {"fresh", "pool", "none"});
  truth.noise = Noise(noise);
}

void read_turbulence(ObjectReader& r, std::optional<TurbulenceConfig>& turbulence) {
  const nlohmann::json* given = r.raw("turbulence");
  if (given == nullptr || r.failed()) return;
  turbulence.reset();
  if (given->is_null()) return;
  TurbulenceConfig& t = turbulence.emplace();
  r.object("turbulence", [&t](ObjectReader& in) {
    in.number("rms_waves", t.rms_waves, 0.0, 10.0);
    in.number("speed_pupils_per_s", t.speed_pupils_per_s, 0.0, kMaxPupilsPerS);
    in.number("direction_deg", t.direction_deg, -360.0, 360.0);
    in.number("outer_scale_pupils", t.outer_scale_pupils, 0.1, 1000.0);
    in.integer("seed", t.seed, 0, 1'000'000);
    in.boolean("tilt", t.tilt);
    in.objects("layers", kMaxLayers, [&t](ObjectReader& layer_in, std::size_t) {
      AirLayer& layer = t.layers.emplace_back();
      layer_in.number("strength", layer.strength, 0.001, 1000.0);
      layer_in.number("speed_pupils_per_s", layer.speed_pupils_per_s, 0.0, kMaxPupilsPerS);
      layer_in.number("direction_deg", layer.direction_deg, -360.0, 360.0);
    });
    in.objects("vibrations", kMaxVibrations, [&t](ObjectReader& vibration_in, std::size_t) {
      Vibration& vibration = t.vibrations.emplace_back();
      for (const char* key : {"j", "rms_waves", "frequency_hz"}) vibration_in.require(key);
      vibration_in.integer("j", vibration.j, 1, Turbulence::kModes - 1);
      vibration_in.number("rms_waves", vibration.rms_waves, 0.0, 10.0);
      vibration_in.number("frequency_hz", vibration.frequency_hz, 0.0, 1000.0);
    });
  });
}

void read_scintillation(ObjectReader& r, std::optional<ScintillationConfig>& scintillation) {
  if (!r.has("scintillation")) return;
  scintillation.reset();
  if (r.is_null("scintillation")) return;
  ScintillationConfig& s = scintillation.emplace();
  r.object("scintillation", [&s](ObjectReader& in) {
    in.number("variance", s.variance, 0.0, 10.0);
    in.number("scale_pupils", s.scale_pupils, 0.02, 10.0);
    in.integer("seed", s.seed, 0, 1'000'000);
  });
}

void read_geometry(ObjectReader& r, CameraGeometry& geometry) {
  r.object("geometry", [&](ObjectReader& in) {
    read_rotation(in, geometry);
    read_scale(in, geometry);
  });
}

const std::vector<std::string>& mirror_names() {
  static const std::vector<std::string> names{"none", "x", "y"};
  return names;
}

Result<Config> parse_config(const std::string& json_text) {
  const auto json = parse_strict_json(json_text, kMaxConfigDepth, JsonComments::allowed);
  if (!json) return fail(Errc::invalid, "", json.error().reason);
  Config config;
  ObjectReader reader(*json, "");
  read_config(reader, config);
  if (auto done = reader.finish(); !done) return fail(done.error());
  if (config.modulator == Modulator::fixed) {
    config.slm.display.clear();
    if (auto done = check_array(config.array, config.optics, config.truth.geometry.magnification);
        !done) {
      return fail(done.error());
    }
  } else if (auto lattice = make_lattice(config.sensor, config.slm.geometry); !lattice) {
    return fail(lattice.error());
  }
  return config;
}

Result<Config> load_config(const std::string& path) {
  const auto text = read_small_file(path);
  if (!text) return fail(Errc::unavailable, "", path + ": " + text.error().reason);
  auto config = parse_config(*text);
  if (!config) config.error().reason += " (in " + path + ")";
  return config;
}

}  // namespace ovws::twin
