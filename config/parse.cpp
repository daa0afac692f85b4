/// From text to Config: which keys there are, and what each may be.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include "config/config.hpp"
#include "proto/endpoint.hpp"
#include "proto/limits.hpp"
#include "proto/names.hpp"
#include "proto/reader.hpp"
#include "proto/strict_json.hpp"

namespace ovws {
namespace {

constexpr int kMaxDepth = 16;
constexpr std::size_t kMaxFileBytes = 1 << 20;

void number(ObjectReader& r, const char* key, double& out, limits::Numbers range) {
  r.number(key, out, range.min, range.max);
}

void integer(ObjectReader& r, const char* key, int& out, limits::Integers range) {
  r.integer(key, out, range.min, range.max);
}

template <class Enum>
void choice(ObjectReader& r, const char* key, Enum& out, const std::vector<std::string>& names) {
  int value = int(out);
  r.choice(key, value, names);
  out = Enum(value);
}

/// A text that must say something.
void text(ObjectReader& r, const char* key, std::string& out) {
  r.string(key, out);
  if (out.empty()) r.fault(key, "must not be empty");
}

void endpoint(ObjectReader& r, const char* key, std::string& out) {
  r.string(key, out);
  if (auto fault = endpoint_fault(out)) r.fault(key, *fault);
}

void read_camera(ObjectReader& r, CameraConfig& camera) {
  CameraSettings& settings = camera.settings;
  text(r, "driver", camera.driver);
  text(r, "id", camera.id);
  choice(r, "pixel_format", settings.pixel_format, pixel_format_names());
  number(r, "exposure_us", settings.exposure_us, limits::kExposureUs);
  number(r, "gain_db", settings.gain_db, limits::kGainDb);
  std::optional<double> gain_raw;
  r.optional_number("gain_raw", gain_raw, limits::kGainRaw.min, limits::kGainRaw.max);
  settings.gain_raw = gain_raw.value_or(settings.gain_raw);
  number(r, "frame_rate_hz", settings.frame_rate_hz, limits::kFrameRateHz);
  r.object("roi", [&settings](ObjectReader& roi) {
    integer(roi, "x", settings.roi.x, limits::kRoiOffset);
    integer(roi, "y", settings.roi.y, limits::kRoiOffset);
    integer(roi, "width", settings.roi.width, limits::kRoiSize);
    integer(roi, "height", settings.roi.height, limits::kRoiSize);
  });
  integer(r, "packet_size_bytes", camera.packet_size_bytes, limits::kPacketSizeBytes);
  number(r, "transfer_ms", camera.transfer_ms, limits::kTransferMs);
}

void read_slm(ObjectReader& r, SlmConfig& slm) {
  text(r, "driver", slm.driver);
  text(r, "display", slm.display);
  integer(r, "width", slm.geometry.width_px, limits::kSlmSizePx);
  integer(r, "height", slm.geometry.height_px, limits::kSlmSizePx);
  number(r, "pitch_um", slm.geometry.pitch_um, limits::kSlmPitchUm);
  r.optional_string("lut", slm.lut);
  r.optional_string("flatness", slm.flatness);
  number(r, "settle_ms", slm.settle_ms, limits::kSettleMs);
  r.boolean("allow_primary", slm.allow_primary);
}

void read_centre(ObjectReader& r, std::optional<Vec2>& centre_px) {
  const auto* value = r.raw("centre_px");
  if (value == nullptr) return;
  if (value->is_null()) return centre_px.reset();
  std::vector<double> xy;
  r.numbers("centre_px", xy, 2, 2, limits::kCentrePx.min, limits::kCentrePx.max);
  if (xy.size() == 2) centre_px = Vec2{xy[0], xy[1]};
}

void read_px_per_cycle(ObjectReader& r, std::optional<PxPerCycle>& registered) {
  const auto* value = r.raw("px_per_cycle");
  if (value == nullptr) return;
  if (value->is_null()) return registered.reset();
  std::vector<double> m;
  r.numbers("px_per_cycle", m, 4, 4, limits::kPxPerCycle.min, limits::kPxPerCycle.max);
  if (m.size() != 4) return;
  const PxPerCycle read{m[0], m[1], m[2], m[3]};
  if (read.scale() < limits::kLeastPxPerCycle) {
    return r.fault("px_per_cycle",
                   "these four numbers map an area to almost nothing: they are "
                   "[xx, xy, yx, yy], camera pixels per cycle per SLM pixel");
  }
  registered = read;
}

void read_optics(ObjectReader& r, OpticsConfig& optics) {
  number(r, "wavelength_nm", optics.wavelength_nm, limits::kWavelengthNm);
  number(r, "focal_length_mm", optics.focal_length_mm, limits::kFocalLengthMm);
  number(r, "magnification", optics.magnification, limits::kMagnification);
  number(r, "camera_pitch_um", optics.camera_pitch_um, limits::kCameraPitchUm);
  read_centre(r, optics.centre_px);
  read_px_per_cycle(r, optics.registered);
}

void read_sensor(ObjectReader& r, SensorConfig& sensor) {
  integer(r, "charge", sensor.charge, limits::kCharge);
  choice(r, "grid", sensor.grid, grid_names());
  integer(r, "subapertures_across", sensor.subapertures_across, limits::kSubaperturesAcross);
  number(r, "pupil_diameter_px", sensor.pupil_diameter_px, limits::kPupilDiameterPx);
  std::vector<double> grooves;
  r.numbers("grooves", grooves, 2, 2, limits::kGrooves.min, limits::kGrooves.max);
  if (grooves.size() == 2) sensor.grooves = {grooves[0], grooves[1]};
  number(r, "spacing", sensor.spacing, limits::kSpacing);
}

void read_tracking(ObjectReader& r, TrackingSettings& tracking) {
  choice(r, "tracker", tracking.tracker, tracker_names());
  choice(r, "template", tracking.templates, template_names());
  choice(r, "operator", tracking.mode_operator, operator_names());
  number(r, "kernel_radius", tracking.kernel_radius, limits::kKernelRadius);
}

void read_refine(ObjectReader& r, RefineSetup& refine) {
  r.boolean("enabled", refine.enabled);
  number(r, "rate_hz", refine.rate_hz, limits::kRefineRateHz);
  r.optional_number("electrons_per_dn", refine.electrons_per_dn, limits::kElectronsPerDn.min,
                    limits::kElectronsPerDn.max);
  number(r, "read_noise_e", refine.read_noise_e, limits::kReadNoiseE);
  number(r, "black_level_dn", refine.black_level_dn, limits::kBlackLevelDn);
  r.optional_number("saturation_dn", refine.saturation_dn, limits::kSaturationDn.min,
                    limits::kSaturationDn.max);
  r.boolean("spot_amplitudes", refine.spot_amplitudes);
  if (auto whole = check_refine(refine); !whole) r.fault(whole.error().field, whole.error().reason);
}

void read_stream(ObjectReader& r, StreamConfig& stream) {
  endpoint(r, "endpoint", stream.endpoint);
  endpoint(r, "image_endpoint", stream.image_endpoint);
  number(r, "image_rate_hz", stream.image_rate_hz, limits::kImageRateHz);
}

void read_state(ObjectReader& r, StateConfig& state) {
  r.optional_string("directory", state.directory);
  if (state.directory && state.directory->empty()) r.fault("directory", "must not be empty");
}

void read_record(ObjectReader& r, RecordConfig& record) {
  r.optional_string("directory", record.directory);
  if (record.directory && record.directory->empty()) r.fault("directory", "must not be empty");
  integer(r, "buffer_mib", record.buffer_mib, limits::kRecordBufferMib);
}

void read_security(ObjectReader& r, SecurityConfig& security) {
  r.optional_string("secret_key", security.secret_key);
  r.optional_string("clients", security.clients);
  if (security.secret_key && security.secret_key->empty())
    r.fault("secret_key", "must not be empty");
  if (security.clients && security.clients->empty()) r.fault("clients", "must not be empty");
  if (security.secret_key.has_value() == security.clients.has_value()) return;
  r.fault(security.clients ? "secret_key" : "clients",
          "secret_key and clients belong together: name both files, or none");
}

void read_cpus(ObjectReader& r, std::vector<int>& cpus) {
  std::vector<double> given;
  r.numbers("cpus", given, 0, limits::kMostCpus, limits::kCpu.min, limits::kCpu.max);
  for (const double cpu : given) {
    if (cpu != std::floor(cpu)) r.fault("cpus", "must be numbers of processors, whole ones");
    if (std::find(cpus.begin(), cpus.end(), int(cpu)) != cpus.end()) {
      r.fault("cpus", "processor " + std::to_string(int(cpu)) + " is given twice");
    }
    cpus.push_back(int(cpu));
  }
}

void read_pipeline(ObjectReader& r, PipelineConfig& pipeline) {
  integer(r, "workers", pipeline.workers, limits::kWorkers);
  integer(r, "records", pipeline.records, limits::kRecords);
  if ((pipeline.records & (pipeline.records - 1)) != 0) {
    r.fault("records", "must be a power of two, not " + std::to_string(pipeline.records));
  }
}

void read_log(ObjectReader& r, LogConfig& log) {
  static const std::vector<std::string> names{"trace", "debug", "info", "warn", "error"};
  int level = -1;
  r.choice("level", level, names);
  if (level >= 0) log.level = names[std::size_t(level)];
}

/// Two sockets cannot have one address; said here, where the keys are known.
void check_endpoints(ObjectReader& r, const Config& config) {
  if (config.stream.endpoint == config.stream.image_endpoint) {
    r.fault("stream.image_endpoint", "must differ from stream.endpoint");
  }
  if (config.control.endpoint == config.stream.endpoint ||
      config.control.endpoint == config.stream.image_endpoint) {
    r.fault("control.endpoint", "must differ from the endpoints of stream");
  }
}

Result<Config> read_config(const nlohmann::json& json) {
  Config config;
  ObjectReader r(json, "");
  r.object("camera", [&config](ObjectReader& o) { read_camera(o, config.camera); });
  r.object("slm", [&config](ObjectReader& o) { read_slm(o, config.slm); });
  r.object("optics", [&config](ObjectReader& o) { read_optics(o, config.optics); });
  r.object("sensor", [&config](ObjectReader& o) { read_sensor(o, config.sensor); });
  r.object("tracking", [&config](ObjectReader& o) { read_tracking(o, config.tracking); });
  config.refine.format = config.camera.settings.pixel_format;
  r.object("refine", [&config](ObjectReader& o) { read_refine(o, config.refine); });
  r.object("stream", [&config](ObjectReader& o) { read_stream(o, config.stream); });
  r.object("control", [&](ObjectReader& o) { endpoint(o, "endpoint", config.control.endpoint); });
  r.object("security", [&config](ObjectReader& o) { read_security(o, config.security); });
  r.object("state", [&config](ObjectReader& o) { read_state(o, config.state); });
  r.object("record", [&config](ObjectReader& o) { read_record(o, config.record); });
  choice(r, "realtime", config.realtime, {"enforce", "ignore"});
  r.object("pipeline", [&config](ObjectReader& o) {
    read_pipeline(o, config.pipeline);
    read_cpus(o, config.frame_path_cpus);
  });
  r.object("log", [&config](ObjectReader& o) { read_log(o, config.log); });
  check_endpoints(r, config);
  if (auto done = r.finish(); !done) return fail(done.error());
  return config;
}

}  // namespace

Result<Config> parse_config(const std::string& json_text) {
  const auto json = parse_strict_json(json_text, kMaxDepth, JsonComments::allowed);
  if (!json) return fail(Errc::invalid, "", json.error().reason);
  return read_config(*json);
}

Result<Config> load_config(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxFileBytes + 1, '\0');
  file.read(text.data(), std::streamsize(text.size()));
  if (file.bad() || !file.eof()) {
    const bool large = file.good();
    return fail(Errc::unavailable, "",
                path + (large ? ": larger than 1 MiB, so not a configuration"
                              : ": cannot be read; is the path right, and are its permissions?"));
  }
  text.resize(std::size_t(file.gcount()));
  auto config = parse_config(text);
  if (config) return config;
  Error error = config.error();
  error.reason = path + ": " + error.reason;
  return fail(std::move(error));
}

}  // namespace ovws
