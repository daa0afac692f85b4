#include "proto/requests.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "proto/limits.hpp"
#include "proto/names.hpp"
#include "proto/reader.hpp"

namespace ovws {
namespace {

using nlohmann::json;

void read_number(ObjectReader& reader, const char* key, std::optional<double>& out,
                 limits::Numbers range) {
  double value = 0.0;
  reader.number(key, value, range.min, range.max);
  if (reader.has(key)) out = value;
}

void read_boolean(ObjectReader& reader, const char* key, std::optional<bool>& out) {
  bool value = false;
  reader.boolean(key, value);
  if (reader.has(key)) out = value;
}

void read_integer(ObjectReader& reader, const char* key, std::optional<int>& out,
                  limits::Integers range) {
  int value = 0;
  reader.integer(key, value, range.min, range.max);
  if (reader.has(key)) out = value;
}

void read_nullable(ObjectReader& reader, const char* key, std::optional<std::optional<double>>& out,
                   limits::Numbers range) {
  std::optional<double> value;
  reader.optional_number(key, value, range.min, range.max);
  if (reader.has(key)) out = value;
}

/// One of an enumeration whose values count from 0 in the order of `names`.
template <class Enum>
void read_choice(ObjectReader& reader, const char* key, std::optional<Enum>& out,
                 const std::vector<std::string>& names) {
  int value = 0;
  reader.choice(key, value, names);
  if (reader.has(key)) out = Enum(value);
}

/// `clamp` comes first, because it changes how the others are read.
bool read_clamp(ObjectReader& reader) {
  bool clamp = false;
  reader.boolean("clamp", clamp);
  reader.clamp(clamp);
  return clamp;
}

void read_roi(ObjectReader& reader, CameraSet& set) {
  reader.object("roi", [&set](ObjectReader& r) {
    read_integer(r, "x", set.roi.x, limits::kRoiOffset);
    read_integer(r, "y", set.roi.y, limits::kRoiOffset);
    read_integer(r, "width", set.roi.width, limits::kRoiSize);
    read_integer(r, "height", set.roi.height, limits::kRoiSize);
  });
}

/// The mode's OSA index, from `j` or from `n` and `m`.
int read_mode_index(ObjectReader& reader) {
  int j = 0, n = 0, m = 0;
  const bool by_j = reader.has("j");
  reader.integer("j", j, 0, kMaxZernikeIndex);
  if (!by_j) {
    reader.require("n");
    reader.require("m");
  }
  reader.integer("n", n, 0, 1000);
  reader.integer("m", m, -1000, 1000);
  if (reader.failed()) return 0;
  if (by_j && (reader.has("n") || reader.has("m"))) {
    reader.fault("j", "give either j, or n and m, not both");
  }
  if (by_j) return j;
  const auto index = checked_osa_index(n, m);
  if (!index) {
    reader.fault("n",
                 "there is no mode with n = " + std::to_string(n) + ", m = " + std::to_string(m) +
                     ": |m| <= n, n - |m| even, and j at most " + std::to_string(kMaxZernikeIndex));
  }
  return index.value_or(0);
}

/// No path, no hidden file, no option of a program.
bool is_plain_name(const std::string& name) {
  const auto is_letter = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
  };
  return !name.empty() && name.size() <= limits::kRecordName && is_letter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return is_letter(c) || c == '.' || c == '_' || c == '-'; });
}

}  // namespace

CameraSettings CameraSet::applied_to(CameraSettings settings) const {
  // One gain in the unit that it was asked for in.
  if (gain_db) settings.gain_raw = kNotKnown;
  if (gain_raw) settings.gain_db = kNotKnown;
  settings.gain_db = gain_db.value_or(settings.gain_db);
  settings.gain_raw = gain_raw.value_or(settings.gain_raw);
  settings.exposure_us = exposure_us.value_or(settings.exposure_us);
  settings.frame_rate_hz = frame_rate_hz.value_or(settings.frame_rate_hz);
  settings.pixel_format = pixel_format.value_or(settings.pixel_format);
  settings.roi.x = roi.x.value_or(settings.roi.x);
  settings.roi.y = roi.y.value_or(settings.roi.y);
  settings.roi.width = roi.width.value_or(settings.roi.width);
  settings.roi.height = roi.height.value_or(settings.roi.height);
  return settings;
}

SensorConfig SensorSet::applied_to(SensorConfig sensor) const {
  sensor.charge = charge.value_or(sensor.charge);
  sensor.grid = grid.value_or(sensor.grid);
  sensor.subapertures_across = subapertures_across.value_or(sensor.subapertures_across);
  sensor.pupil_diameter_px = pupil_diameter_px.value_or(sensor.pupil_diameter_px);
  sensor.grooves = grooves.value_or(sensor.grooves);
  sensor.spacing = spacing.value_or(sensor.spacing);
  return sensor;
}

TrackingSettings SensorSet::applied_to(TrackingSettings tracking) const {
  tracking.tracker = tracker.value_or(tracking.tracker);
  tracking.templates = templates.value_or(tracking.templates);
  tracking.mode_operator = mode_operator.value_or(tracking.mode_operator);
  return tracking;
}

RefineSetup RefineSet::applied_to(RefineSetup settings) const {
  settings.enabled = enabled.value_or(settings.enabled);
  settings.rate_hz = rate_hz.value_or(settings.rate_hz);
  settings.electrons_per_dn = electrons_per_dn.value_or(settings.electrons_per_dn);
  settings.read_noise_e = read_noise_e.value_or(settings.read_noise_e);
  settings.black_level_dn = black_level_dn.value_or(settings.black_level_dn);
  settings.saturation_dn = saturation_dn.value_or(settings.saturation_dn);
  settings.spot_amplitudes = spot_amplitudes.value_or(settings.spot_amplitudes);
  if (clamp && settings.saturation_dn) {
    settings.saturation_dn = std::min(*settings.saturation_dn, full_scale_dn(settings.format));
  }
  return settings;
}

Result<CameraSet> decode_camera_set(const json& params) {
  CameraSet set;
  ObjectReader reader(params, "");
  set.clamp = read_clamp(reader);
  // Null as camera.get gives them: leave it.
  reader.optional_number("gain_db", set.gain_db, limits::kGainDb.min, limits::kGainDb.max);
  reader.optional_number("gain_raw", set.gain_raw, limits::kGainRaw.min, limits::kGainRaw.max);
  if (set.gain_db && set.gain_raw)
    reader.fault("gain_raw",
                 "cannot be set together with gain_db: set the one that camera.get has");
  read_number(reader, "exposure_us", set.exposure_us, limits::kExposureUs);
  read_number(reader, "frame_rate_hz", set.frame_rate_hz, limits::kFrameRateHz);
  read_choice(reader, "pixel_format", set.pixel_format, pixel_format_names());
  read_roi(reader, set);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return set;
}

Result<SensorSet> decode_sensor_set(const json& params) {
  SensorSet set;
  ObjectReader reader(params, "");
  set.clamp = read_clamp(reader);
  read_integer(reader, "charge", set.charge, limits::kCharge);
  read_choice(reader, "grid", set.grid, grid_names());
  read_integer(reader, "subapertures_across", set.subapertures_across, limits::kSubaperturesAcross);
  read_number(reader, "pupil_diameter_px", set.pupil_diameter_px, limits::kPupilDiameterPx);
  std::vector<double> grooves;
  reader.numbers("grooves", grooves, 2, 2, limits::kGrooves.min, limits::kGrooves.max);
  if (grooves.size() == 2) set.grooves = {grooves[0], grooves[1]};
  read_number(reader, "spacing", set.spacing, limits::kSpacing);
  read_choice(reader, "tracker", set.tracker, tracker_names());
  read_choice(reader, "template", set.templates, template_names());
  read_choice(reader, "operator", set.mode_operator, operator_names());
  if (auto done = reader.finish(); !done) return fail(done.error());
  return set;
}

Result<RefineSet> decode_refine_set(const json& params) {
  RefineSet set;
  ObjectReader reader(params, "");
  set.clamp = read_clamp(reader);
  read_boolean(reader, "enabled", set.enabled);
  read_number(reader, "rate_hz", set.rate_hz, limits::kRefineRateHz);
  read_nullable(reader, "electrons_per_dn", set.electrons_per_dn, limits::kElectronsPerDn);
  read_number(reader, "read_noise_e", set.read_noise_e, limits::kReadNoiseE);
  read_number(reader, "black_level_dn", set.black_level_dn, limits::kBlackLevelDn);
  read_nullable(reader, "saturation_dn", set.saturation_dn, limits::kSaturationDn);
  read_boolean(reader, "spot_amplitudes", set.spot_amplitudes);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return set;
}

Result<std::vector<Mode>> decode_aberration_set(const json& params) {
  std::vector<Mode> modes;
  std::set<int> given;
  ObjectReader reader(params, "");
  int norm = 0;
  reader.choice("norm", norm, norm_names());
  reader.require("modes");
  reader.objects("modes", kMaxZernikeIndex + 1, [&](ObjectReader& r, std::size_t) {
    Mode mode;
    mode.j = read_mode_index(r);
    r.require("waves");
    r.number("waves", mode.waves, limits::kModeWaves.min, limits::kModeWaves.max);
    if (r.failed()) return;
    if (!given.insert(mode.j).second) {
      r.fault("", "the mode j = " + std::to_string(mode.j) + " is given twice");
    }
    // a Z_unit = (a / factor) Z_rms
    if (ZernikeNorm(norm) == ZernikeNorm::unit) mode.waves /= zernike_rms_factor(mode.j);
    modes.push_back(mode);
  });
  if (auto done = reader.finish(); !done) return fail(done.error());
  return modes;
}

Result<ReferenceTake> decode_reference_take(const json& params) {
  ReferenceTake take;
  ObjectReader reader(params, "");
  reader.integer("frames", take.frames, limits::kReferenceFrames.min, limits::kReferenceFrames.max);
  reader.boolean("allow_aberration", take.allow_aberration);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return take;
}

Result<int> decode_registration_run(const json& params) {
  int frames = 5;
  ObjectReader reader(params, "");
  reader.integer("frames", frames, limits::kPictureFrames.min, limits::kPictureFrames.max);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return frames;
}

Result<LutRun> decode_lut_run(const json& params) {
  LutRun run;
  ObjectReader reader(params, "");
  reader.integer("levels", run.levels, limits::kGreyLevels.min, limits::kGreyLevels.max);
  reader.integer("frames", run.frames, limits::kPictureFrames.min, limits::kPictureFrames.max);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return run;
}

Result<int> decode_flatness_run(const json& params) {
  int frames = 5;
  ObjectReader reader(params, "");
  reader.integer("frames", frames, limits::kPictureFrames.min, limits::kPictureFrames.max);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return frames;
}

Result<SettleRun> decode_slm_settle(const json& params) {
  SettleRun run;
  ObjectReader reader(params, "");
  reader.integer("repetitions", run.repetitions, limits::kSettleRepetitions.min,
                 limits::kSettleRepetitions.max);
  reader.number("watch_ms", run.watch_ms, limits::kWatchMs.min, limits::kWatchMs.max);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return run;
}

Result<void> decode_reference_set(const json& params) {
  int source = 0;
  ObjectReader reader(params, "");
  reader.require("source");
  reader.choice("source", source, {"model"});
  return reader.finish();
}

Result<CalibrationRun> decode_calibration_run(const json& params) {
  CalibrationRun run;
  std::vector<double> modes;
  ObjectReader reader(params, "");
  reader.number("amplitude_waves", run.amplitude_waves, limits::kPushWaves.min,
                limits::kPushWaves.max);
  reader.integer("frames", run.frames, limits::kPushFrames.min, limits::kPushFrames.max);
  reader.numbers("modes", modes, 1, kMaxZernikeIndex, 1, kMaxZernikeIndex);
  std::set<int> given;
  for (const double mode : modes) {
    if (mode != std::floor(mode)) reader.fault("modes", "must be OSA indices, whole numbers");
    if (!given.insert(int(mode)).second) {
      reader.fault("modes", "the mode j = " + std::to_string(int(mode)) + " is given twice");
    }
  }
  if (auto done = reader.finish(); !done) return fail(done.error());
  if (!given.empty()) run.modes_j.emplace(given.begin(), given.end());
  return run;
}

Result<HologramKind> decode_slm_show(const json& params) {
  std::optional<HologramKind> pattern;
  ObjectReader reader(params, "");
  reader.require("pattern");
  read_choice(reader, "pattern", pattern, showable_pattern_names());
  if (auto done = reader.finish(); !done) return fail(done.error());
  return *pattern;
}

Result<LoopSettings> decode_loop_close(const json& params) {
  LoopSettings settings;
  ObjectReader reader(params, "");
  reader.number("gain", settings.gain, limits::kLoopGain.min, limits::kLoopGain.max);
  reader.number("leak", settings.leak, limits::kLoopLeak.min, limits::kLoopLeak.max);
  reader.number("limit_waves", settings.limit_waves, limits::kLoopLimitWaves.min,
                limits::kLoopLimitWaves.max);
  reader.number("patience_s", settings.patience_s, limits::kLoopPatienceS.min,
                limits::kLoopPatienceS.max);
  std::vector<double> modes;
  reader.numbers("modes", modes, 1, kMaxZernikeIndex, 1, kMaxZernikeIndex);
  for (const double j : modes) {
    if (j != std::floor(j)) reader.fault("modes", "must be whole numbers: OSA indices");
    if (std::find(settings.modes.begin(), settings.modes.end(), int(j)) != settings.modes.end()) {
      reader.fault("modes", "the mode j = " + std::to_string(int(j)) + " is given twice");
    }
    settings.modes.push_back(int(j));
  }
  reader.objects("gains", kMaxZernikeIndex, [&](ObjectReader& r, std::size_t) {
    ModeGain one;
    r.require("j");
    r.require("gain");
    r.integer("j", one.j, 1, kMaxZernikeIndex);
    r.number("gain", one.gain, 0.0, limits::kLoopGain.max);
    const bool known = std::any_of(settings.gains.begin(), settings.gains.end(),
                                   [&](const ModeGain& other) { return other.j == one.j; });
    if (known) r.fault("j", "the mode j = " + std::to_string(one.j) + " is given twice");
    settings.gains.push_back(one);
  });
  if (auto done = reader.finish(); !done) return fail(done.error());
  return settings;
}

Result<bool> decode_loop_open(const json& params) {
  bool keep = true;
  ObjectReader reader(params, "");
  reader.boolean("keep", keep);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return keep;
}

Result<RecordStart> decode_record_start(const json& params) {
  RecordStart start;
  ObjectReader reader(params, "");
  reader.require("name");
  reader.string("name", start.name);
  reader.integer("pictures_every", start.pictures_every, limits::kPicturesEvery.min,
                 limits::kPicturesEvery.max);
  reader.optional_number("limit_s", start.limit_s, limits::kRecordS.min, limits::kRecordS.max);
  reader.optional_number("limit_mib", start.limit_mib, limits::kRecordMib.min,
                         limits::kRecordMib.max);
  if (reader.has("name") && !is_plain_name(start.name)) {
    reader.fault("name",
                 "must be a plain name: letters, digits, '.', '_' and '-', at most 100 of them, "
                 "the first a letter or a digit; the folder is record.directory");
  }
  if (auto done = reader.finish(); !done) return fail(done.error());
  return start;
}

Result<int> decode_job(const json& params) {
  int job = 0;
  ObjectReader reader(params, "");
  reader.require("job");
  reader.integer("job", job, limits::kJob.min, limits::kJob.max);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return job;
}

Result<void> decode_nothing(const json& params) {
  return ObjectReader(params, "").finish();
}

}  // namespace ovws
