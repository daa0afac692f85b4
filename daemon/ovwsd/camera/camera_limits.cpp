#include "daemon/ovwsd/camera/camera_limits.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

namespace ovws {
namespace {

/// Range check of settings: refuses or clamps values out of range. Keeps the first error.
class LimitCheck {
 public:
  explicit LimitCheck(bool clamp) : clamp_(clamp) {}

  template <class T>
  void number(const char* field, T& value, T min, T max, const char* unit) {
    if (value >= min && value <= max) return;
    if (clamp_) {
      value = std::clamp(value, min, max);
    } else if (!error_) {
      error_ = Error{
          Errc::invalid, field,
          fmt::format("{} is outside the camera's range of {} to {} {}", value, min, max, unit),
          double(min), double(max)};
    }
  }

  /// Checks the gain, which must be in the camera's own unit: dB or raw steps.
  void gain(CameraSettings& settings, const CameraLimits& limits) {
    const bool in_db = !std::isnan(settings.gain_db) && settings.gain_db != 0.0;
    if (limits.gain_raw) {
      if (in_db) return refuse(no_gain_in_db("gain_db", limits));
      if (std::isnan(settings.gain_raw)) return;
      const Range<double>& range = *limits.gain_raw;
      return number("gain_raw", settings.gain_raw, range.min, range.max,
                    "in the camera's own steps");
    }
    const Range<double>& range = limits.gain_db;
    if (!std::isnan(settings.gain_raw))
      return refuse(
          {Errc::invalid, "gain_raw",
           fmt::format("the camera has its gain in dB: instead of gain_raw set gain_db, {} to {}",
                       range.min, range.max)});
    number("gain_db", settings.gain_db, range.min, range.max, "dB");
  }

  void format(PixelFormat wanted, const std::vector<PixelFormat>& supported) {
    if (error_ || std::find(supported.begin(), supported.end(), wanted) != supported.end()) return;
    std::string names;
    for (const PixelFormat format : supported) {
      names += (names.empty() ? "" : ", ") + std::string(pixel_format_name(format));
    }
    error_ = Error{Errc::invalid, "pixel_format",
                   fmt::format("the camera has no pixel format {}: choose one of {}",
                               pixel_format_name(wanted), names)};
  }

  const std::optional<Error>& error() const { return error_; }

 private:
  void refuse(Error error) {
    if (!error_) error_ = std::move(error);
  }

  bool clamp_;
  std::optional<Error> error_;
};

}  // namespace

Error no_gain_in_db(std::string field, const CameraLimits& limits) {
  return {Errc::invalid, std::move(field),
          fmt::format("the camera has no gain in dB, only its own steps: gain_raw, {} to {}",
                      limits.gain_raw->min, limits.gain_raw->max)};
}

Result<CameraSettings> within_limits(const CameraSettings& wanted, const CameraLimits& limits,
                                     bool clamp) {
  CameraSettings settings = wanted;
  LimitCheck check(clamp);
  check.gain(settings, limits);
  if (clamp) {
    settings.exposure_us =
        std::clamp(settings.exposure_us, limits.exposure_us.min, limits.exposure_us.max);
    settings.frame_rate_hz =
        std::clamp(settings.frame_rate_hz, limits.frame_rate_hz.min, limits.frame_rate_hz.max);
  }
  check.format(settings.pixel_format, limits.pixel_formats);
  Roi& roi = settings.roi;
  check.number("roi.width", roi.width, limits.roi_width.min, limits.sensor_width, "px");
  check.number("roi.height", roi.height, limits.roi_height.min, limits.sensor_height, "px");
  check.number("roi.x", roi.x, 0, std::max(0, limits.sensor_width - roi.width),
               "px for this roi.width");
  check.number("roi.y", roi.y, 0, std::max(0, limits.sensor_height - roi.height),
               "px for this roi.height");
  if (check.error()) return fail(*check.error());
  if (clamp) roi.width -= roi.width % pixels_per_group(settings.pixel_format);
  return settings;
}

}  // namespace ovws
