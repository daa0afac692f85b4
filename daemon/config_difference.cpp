#include "daemon/config_difference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

namespace ovws {
namespace {

/// What begins so, and is not among the fixed ones, changes live.
constexpr std::array<std::string_view, 11> kLive{"camera.pixel_format",
                                                 "camera.exposure_us",
                                                 "camera.gain_db",
                                                 "camera.gain_raw",
                                                 "camera.frame_rate_hz",
                                                 "camera.roi.",
                                                 "sensor.",
                                                 "tracking.",
                                                 "refine.",
                                                 "stream.image_rate_hz",
                                                 "log.level"};
constexpr std::array<std::string_view, 1> kFixed{"tracking.kernel_radius"};

bool is_live(std::string_view key) {
  const auto begins = [key](std::string_view start) { return key.starts_with(start); };
  return std::any_of(kLive.begin(), kLive.end(), begins) &&
         std::none_of(kFixed.begin(), kFixed.end(), begins);
}

template <class T>
void undo_rounding(T& file, const T& asked, const T& in_use) {
  if (file == in_use) file = asked;
}

template <class T>
void take_difference(std::optional<T>& change, const T& before, const T& after) {
  if (!(before == after)) change = after;
}

}  // namespace

ConfigDifference difference(const Config& before, const Config& after) {
  const auto now = nlohmann::json::parse(dump_config(before), nullptr, false).flatten();
  const auto wanted = nlohmann::json::parse(dump_config(after), nullptr, false).flatten();
  ConfigDifference keys;
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
  look_at(now, wanted, false);  // a list became null
  return keys;
}

CameraSettings as_asked(CameraSettings file, const CameraSnapshot& now) {
  const CameraSettings &asked = now.asked, &in_use = now.settings;
  undo_rounding(file.gain_db, asked.gain_db, in_use.gain_db);
  undo_rounding(file.gain_raw, asked.gain_raw, in_use.gain_raw);
  undo_rounding(file.exposure_us, asked.exposure_us, in_use.exposure_us);
  undo_rounding(file.frame_rate_hz, asked.frame_rate_hz, in_use.frame_rate_hz);
  undo_rounding(file.roi.x, asked.roi.x, in_use.roi.x);
  undo_rounding(file.roi.y, asked.roi.y, in_use.roi.y);
  undo_rounding(file.roi.width, asked.roi.width, in_use.roi.width);
  undo_rounding(file.roi.height, asked.roi.height, in_use.roi.height);
  return file;
}

CameraSet camera_change(const CameraSettings& before, const CameraSettings& after) {
  CameraSet change;
  if (!same_gain(before, after)) {
    // Only the gain that is stated: the other one is not known.
    if (std::isnan(after.gain_raw))
      change.gain_db = after.gain_db;
    else
      change.gain_raw = after.gain_raw;
  }
  take_difference(change.exposure_us, before.exposure_us, after.exposure_us);
  take_difference(change.frame_rate_hz, before.frame_rate_hz, after.frame_rate_hz);
  take_difference(change.pixel_format, before.pixel_format, after.pixel_format);
  take_difference(change.roi.x, before.roi.x, after.roi.x);
  take_difference(change.roi.y, before.roi.y, after.roi.y);
  take_difference(change.roi.width, before.roi.width, after.roi.width);
  take_difference(change.roi.height, before.roi.height, after.roi.height);
  return change;
}

}  // namespace ovws
