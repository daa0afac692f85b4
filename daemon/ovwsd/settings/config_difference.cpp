#include "daemon/ovwsd/settings/config_difference.hpp"

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

/// Applies `rule` to each setting that a camera may round.
template <class Rule>
void for_each_rounded(CameraSettings& to, const CameraSettings& a, const CameraSettings& b,
                      Rule rule) {
  rule(to.gain_db, a.gain_db, b.gain_db);
  rule(to.gain_raw, a.gain_raw, b.gain_raw);
  rule(to.exposure_us, a.exposure_us, b.exposure_us);
  rule(to.frame_rate_hz, a.frame_rate_hz, b.frame_rate_hz);
  rule(to.roi.x, a.roi.x, b.roi.x);
  rule(to.roi.y, a.roi.y, b.roi.y);
  rule(to.roi.width, a.roi.width, b.roi.width);
  rule(to.roi.height, a.roi.height, b.roi.height);
}

}  // namespace

Config config_in_use(const Config& started, const LoadedConfig& loaded, const CameraActor& camera,
                     const SlmLoop& slm, const SensorKeeper& keeper, const LiveRefiner& refiner) {
  const SensorView sensor = keeper.snapshot();
  const CameraSnapshot of_camera = camera.snapshot();
  Config now = started;
  now.stream.image_rate_hz = loaded.effective.stream.image_rate_hz;
  now.log.level = loaded.effective.log.level;
  now.camera.id = of_camera.id;
  now.camera.settings = of_camera.settings;
  use_settings(now.slm, slm.snapshot().settings);
  if (started.sensor.lenslets.empty()) now.sensor = sensor->sensor;
  now.tracking = sensor->tracking;
  now.refine = in_format(refiner.settings(), now.camera.settings.pixel_format);
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
  for_each_rounded(file, now.asked, now.settings,
                   [](auto& value, const auto& asked, const auto& in_use) {
                     if (value == in_use) value = asked;
                   });
  return file;
}

CameraSettings as_in_file(CameraSettings in_use, const CameraSettings& asked,
                          const CameraSettings& file) {
  for_each_rounded(in_use, asked, file, [](auto& value, const auto& wanted, const auto& written) {
    if (wanted == written) value = written;
  });
  return in_use;
}

}  // namespace ovws
