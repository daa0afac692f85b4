#include "daemon/ovwsd/settings/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "proto/json_text.hpp"

namespace ovws {
namespace {

/// Prefixes of keys that can change at run time, except those that begin with a prefix in kFixed.
constexpr std::array<std::string_view, 15> kLive{"camera.id",
                                                 "camera.pixel_format",
                                                 "camera.exposure_us",
                                                 "camera.gain_db",
                                                 "camera.gain_raw",
                                                 "camera.frame_rate_hz",
                                                 "camera.roi.",
                                                 "slm.display",
                                                 "slm.allow_primary",
                                                 "slm.settle_ms",
                                                 "sensor.",
                                                 "tracking.",
                                                 "refine.",
                                                 "stream.image_rate_hz",
                                                 "log.level"};
/// Values that change as a whole.
constexpr std::array<const char*, 2> kWhole{"/sensor/mask", "/sensor/charges"};
constexpr std::array<std::string_view, 1> kFixed{"tracking.kernel_radius"};

}  // namespace

Config Settings::with(const CameraSnapshot& camera) const {
  const SensorView sensor = keeper_.snapshot();
  const Config loaded = loaded_.get().effective;
  Config now = started_;
  now.stream.image_rate_hz = loaded.stream.image_rate_hz;
  now.log.level = loaded.log.level;
  now.camera.id = camera.id;
  now.camera.settings = camera.settings;
  static_cast<SlmSettings&>(now.slm) = slm_.snapshot().settings;
  if (started_.sensor.lenslets.empty()) now.sensor = sensor->sensor;
  now.tracking = sensor->tracking;
  now.refine = in_format(refiner_.settings(), now.camera.settings.pixel_format);
  return now;
}

Config Settings::requested() const {
  const CameraSnapshot camera = camera_.snapshot();
  Config now = with(camera);
  now.camera.settings = camera.asked;
  return now;
}

bool changes_live(std::string_view key) {
  const auto begins = [key](std::string_view start) { return key.starts_with(start); };
  return std::any_of(kLive.begin(), kLive.end(), begins) &&
         std::none_of(kFixed.begin(), kFixed.end(), begins);
}

nlohmann::json flat(const Config& config) {
  const nlohmann::json tree = json_of(dump_config(config));
  nlohmann::json parts = tree;
  for (const char* key : kWhole) parts[nlohmann::json::json_pointer(key)] = nullptr;
  nlohmann::json all = parts.flatten();
  for (const char* key : kWhole) all[key] = tree.at(nlohmann::json::json_pointer(key));
  return all;
}

ConfigDifference difference(const Config& before, const Config& after) {
  const auto now = flat(before), wanted = flat(after);
  ConfigDifference keys;
  const bool is_fixed = before.modulator == Modulator::fixed || after.modulator == Modulator::fixed;
  const auto is_live = [is_fixed](const std::string& key) {
    return changes_live(key) && !(is_fixed && key.starts_with("sensor."));
  };
  const auto look_at = [&](const nlohmann::json& these, const nlohmann::json& others, bool all) {
    for (const auto& [pointer, value] : these.items()) {
      const bool there = others.contains(pointer);
      if (there && (!all || others[pointer] == value)) continue;
      std::string key = pointer.substr(1);
      std::replace(key.begin(), key.end(), '/', '.');
      (is_live(key) ? keys.live : keys.restart).push_back(std::move(key));
    }
  };
  look_at(wanted, now, true);
  look_at(now, wanted, false);  // keys missing in `after`: a list became null
  return keys;
}

CameraSettings as_requested(CameraSettings file, const CameraSnapshot& now) {
  const auto undo = [](auto& value, const auto& asked, const auto& in_use) {
    if (value == in_use) value = asked;
  };
  undo(file.gain_db, now.asked.gain_db, now.settings.gain_db);
  undo(file.gain_raw, now.asked.gain_raw, now.settings.gain_raw);
  undo(file.exposure_us, now.asked.exposure_us, now.settings.exposure_us);
  undo(file.frame_rate_hz, now.asked.frame_rate_hz, now.settings.frame_rate_hz);
  undo(file.roi.x, now.asked.roi.x, now.settings.roi.x);
  undo(file.roi.y, now.asked.roi.y, now.settings.roi.y);
  undo(file.roi.width, now.asked.roi.width, now.settings.roi.width);
  undo(file.roi.height, now.asked.roi.height, now.settings.roi.height);
  return file;
}

}  // namespace ovws
