#include "daemon/ovwsd/library/bench_key.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/tables.hpp"
#include "core/optics/lattice.hpp"
#include "proto/json_text.hpp"
#include "proto/tables/origin.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr double kScaleTolerance = 0.002;  // relative to px_per_cycle

/// The value as text; long ones, such as the places of lenslets, only by their beginning.
std::string brief(const json& value) {
  constexpr std::size_t kMost = 60;
  std::string text = json_text(value);
  if (text.size() > kMost) text.replace(kMost, std::string::npos, " ...");
  return text;
}

/// Describes the keys below `path` whose values differ; a missing key counts as null.
std::string difference(const std::string& path, const json& then, const json& now) {
  if (!then.is_object() || !now.is_object()) {
    if (then == now) return "";
    const std::string before = brief(then), after = brief(now);
    if (before == after) return path + " was other than it is now";
    return path + " was " + before + ", and is " + after;
  }
  json keys = then;
  keys.update(now);
  std::string all;
  for (const auto& [key, value] : keys.items()) {
    const std::string one =
        difference(path + "." + key, then.value(key, json()), now.value(key, json()));
    if (!one.empty()) all += (all.empty() ? "" : "; ") + one;
  }
  return all;
}

/// Replaces invalid UTF-8: a camera may report any bytes, but JSON files hold UTF-8 only.
std::string as_utf8(const std::string& text) {
  return json_of(json_text(json(text)));
}

/// The values of these keys.
json part_of(const json& object, std::initializer_list<const char*> keys) {
  json part = json::object();
  for (const char* key : keys) part[key] = object.is_object() ? object.value(key, json()) : json();
  return part;
}

json wavelength_of(const BenchKey& key) {
  return part_of(key.optics, {"wavelength_nm"});
}
json imaging_of(const BenchKey& key) {
  return part_of(key.optics, {"focal_length_mm", "magnification", "camera_pitch_um"});
}
json geometry_of(const BenchKey& key) {
  return part_of(key.slm, {"width", "height", "pitch_um"});
}
json levels_of(const BenchKey& key) {
  return part_of(key.slm, {"lut_sha256", "flatness_sha256"});
}

struct Bench {
  OpticsConfig optics;
  SlmGeometry slm;
};
/// The typed optics and geometry of a key, which its JSON was made of.
Bench bench_of(const BenchKey& key) {
  Bench bench;
  if (auto optics = decode<OpticsConfig>(key.optics)) bench.optics = *optics;
  if (auto slm = decode<SlmGeometry>(geometry_of(key))) bench.slm = *slm;
  bench.optics = optics_of(key, bench.optics);
  return bench;
}

bool has_same_map(const BenchKey& a, const BenchKey& b) {
  return a.px_per_cycle == b.px_per_cycle && a.base_px == b.base_px;
}

bool has_equal_registration(const BenchKey& then, const BenchKey& now) {
  if (has_same_map(then, now)) return true;
  const PxPerCycle &p = then.px_per_cycle, &q = now.px_per_cycle;
  const double off = std::max(std::hypot(p.xx - q.xx, p.yx - q.yx),  //
                              std::hypot(p.xy - q.xy, p.yy - q.yy));
  if (off > kScaleTolerance * p.scale()) return false;
  const Bench bench = bench_of(then);
  return !(then.roi == now.roi) ||
         norm(then.base_px - now.base_px) <=
             kPositionTolerance * lambda_d_px(bench.optics, bench.slm, then.sensor);
}

bool is_array(const BenchKey& key) {
  return !key.sensor.lenslets.empty();
}

std::string sensor_words(const BenchKey& then, const BenchKey& now) {
  if (is_array(then) && is_array(now)) {
    return "the lenslets have been measured elsewhere since it was taken";
  }
  return difference("sensor", to_json(then.sensor), to_json(now.sensor));
}

std::string tracking_words(const TrackingSettings& then, const TrackingSettings& now) {
  return difference("tracking", to_json(ConfiguredTracking(then)),
                    to_json(ConfiguredTracking(now)));
}

}  // namespace

void use_map(BenchKey& key, const std::optional<Registration>& registration,
             const OpticsConfig& configured, const SlmGeometry& slm) {
  if (registration) {
    key.px_per_cycle = registration->px_per_cycle;
    key.base_px = registration->base_px;
    return;
  }
  const Roi& roi = key.roi;
  key.px_per_cycle = px_per_cycle(configured, slm);
  key.base_px =
      base_spot_px(configured, roi.width, roi.height) + Vec2{double(roi.x), double(roi.y)};
}

OpticsConfig optics_of(const BenchKey& key, OpticsConfig configured) {
  configured.registered = key.px_per_cycle;
  configured.centre_px = key.base_px - Vec2{double(key.roi.x), double(key.roi.y)};
  return configured;
}

json camera_json(const std::optional<CameraInfo>& camera) {
  if (!camera) return nullptr;
  return to_json(
      CameraName{as_utf8(camera->vendor), as_utf8(camera->model), as_utf8(camera->serial)});
}

json array_json(const Config& config) {
  if (config.modulator != Modulator::fixed) return nullptr;
  json array = part_of(to_json(config.array), {"pitch_um", "pupil_mm"});
  array["grid"] = to_json(config.sensor.grid);
  return array;
}

TrackingSettings by_positions(TrackingSettings tracking) {
  if (tracking.tracker == TrackerKind::fit) tracking.tracker = TrackerKind::lg;
  return tracking;
}

TrackingSettings position_tracking(const TrackingSettings& tracking) {
  TrackingSettings needed = by_positions(tracking);
  needed.mode_operator = OperatorKind::slopes;
  needed.mode_count.reset();
  needed.estimates = TrackingSettings{}.estimates;
  return needed;
}

TrackingSettings calibrated_tracking(const TrackingSettings& tracking) {
  TrackingSettings needed = position_tracking(tracking);
  if (tracking.tracker != TrackerKind::fit) return needed;
  needed.tracker = TrackerKind::fit;
  needed.mode_count = tracking.mode_count;
  return needed;
}

respect::Set differing(respect::Set of, const BenchKey& then, const BenchKey& now) {
  using namespace respect;
  Set found = 0;
  const auto compare = [&](Set one, auto equal) {
    if ((of & one) != 0 && !equal()) found |= one;
  };
  compare(kSensor, [&] { return then.sensor == now.sensor; });
  compare(kPositions,
          [&] { return position_tracking(then.tracking) == position_tracking(now.tracking); });
  compare(kShapes,
          [&] { return calibrated_tracking(then.tracking) == calibrated_tracking(now.tracking); });
  compare(kRoi, [&] { return then.roi == now.roi; });
  compare(kOptics, [&] { return then.optics == now.optics; });
  compare(kWavelength, [&] { return wavelength_of(then) == wavelength_of(now); });
  compare(kImaging, [&] { return imaging_of(then) == imaging_of(now); });
  compare(kSlm, [&] { return geometry_of(then) == geometry_of(now); });
  compare(kLevels, [&] { return levels_of(then) == levels_of(now); });
  compare(kArray, [&] { return then.array == now.array; });
  compare(kFlatnessFile, [&] { return then.flatness_file == now.flatness_file; });
  compare(kCamera, [&] {
    return then.camera.is_null() || now.camera.is_null() || then.camera == now.camera;
  });
  compare(kMap, [&] { return has_equal_registration(then, now); });
  if (found == 0) {
    compare(kPlaces, [&] {
      if (has_same_map(then, now)) return true;
      const auto [farthest_px, lambda_d_px] = displacement(then, now);
      return farthest_px <= kPositionTolerance * lambda_d_px;
    });
  }
  return found;
}

Displacement displacement(const BenchKey& then, const BenchKey& now) {
  const Bench bench = bench_of(now);
  const auto lattice = make_lattice(now.sensor, bench.slm);
  if (!lattice) return {std::numeric_limits<double>::infinity(), 0.0};
  const auto positions = [&](const BenchKey& key) {
    return model_spots_px(*lattice, now.sensor, bench.slm, optics_of(key, bench.optics),
                          key.roi.width, key.roi.height);
  };
  const std::vector<Vec2> before = positions(then), after = positions(now);
  Displacement found{0.0, lambda_d_px(bench.optics, bench.slm, now.sensor)};
  for (std::size_t i = 0; i < after.size(); ++i) {
    found.farthest_px = std::max(found.farthest_px, norm(after[i] - before[i]));
  }
  return found;
}

std::string words_of(respect::Set differing, const BenchKey& then, const BenchKey& now) {
  using namespace respect;
  std::string words;
  const auto describe = [&](Set one, auto text) {
    if ((differing & one) != 0) words += (words.empty() ? "" : "; ") + std::string(text());
  };
  describe(kSensor, [&] { return sensor_words(then, now); });
  describe(kPositions, [&] {
    return tracking_words(position_tracking(then.tracking), position_tracking(now.tracking));
  });
  describe(kShapes, [&] {
    return tracking_words(calibrated_tracking(then.tracking), calibrated_tracking(now.tracking));
  });
  describe(kRoi, [&] { return difference("camera.roi", to_json(then.roi), to_json(now.roi)); });
  describe(kOptics, [&] { return difference("optics", then.optics, now.optics); });
  describe(kWavelength,
           [&] { return difference("optics", wavelength_of(then), wavelength_of(now)); });
  describe(kImaging, [&] { return difference("optics", imaging_of(then), imaging_of(now)); });
  describe(kSlm, [&] { return difference("slm", geometry_of(then), geometry_of(now)); });
  describe(kLevels, [] { return "it was taken with another look-up table or flatness"; });
  describe(kArray, [&] { return difference("array", then.array, now.array); });
  describe(kFlatnessFile, [&] {
    return difference("slm.flatness, by SHA-256,", then.flatness_file, now.flatness_file);
  });
  describe(kCamera, [&] { return difference("camera", then.camera, now.camera); });
  describe(kMap, [] { return "the registration is another one"; });
  describe(kPlaces, [] { return "the expected spot positions have changed since it was taken"; });
  return words;
}

bool is_by_choice(respect::Set differing, const BenchKey& then, const BenchKey& now) {
  using namespace respect;
  const bool array = is_array(then) && is_array(now);
  return (differing & (array ? kChosen & ~kSensor : kChosen)) != 0;
}

}  // namespace ovws
