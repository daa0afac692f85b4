/// Range checks of camera settings. Error messages name the value, its range and the remedy.
#include "drivers/aravis/settings_check.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/number_text.hpp"

namespace ovws {

namespace {

std::string describe(double value) {
  constexpr int kDigits = 10;
  return with_digits(value, kDigits);
}

template <class T>
std::string describe(const Range<T>& range) {
  const std::string text = describe(range.min) + " to " + describe(range.max);
  return range.increment > T{} ? text + " in steps of " + describe(range.increment) : text;
}

/// Largest region width or height up to `wanted` that the camera's increment allows.
int fit_extent(int wanted, const Range<int>& range) {
  const int step = std::max(range.increment, 1);
  return std::min(range.min + (wanted - range.min) / step * step, range.max);
}

bool lies_on_sensor(int offset, int extent, int sensor) {
  return offset >= 0 && extent > 0 && extent <= sensor && offset <= sensor - extent;
}

}  // namespace

Result<double> fit_value(const std::string& field, const char* what, double wanted,
                         const Range<double>& range) {
  if (!std::isfinite(wanted) || wanted < range.min || wanted > range.max) {
    Error error{Errc::invalid, field,
                std::string(what) + " of " + describe(wanted) +
                    " is out of range; this camera now accepts " + describe(range)};
    error.min = range.min;
    error.max = range.max;
    return fail(std::move(error));
  }
  if (range.increment <= 0.0) return wanted;
  const double steps = std::round((wanted - range.min) / range.increment);
  return std::clamp(range.min + steps * range.increment, range.min, range.max);
}

Result<Roi> fit_roi(const Roi& wanted, const CameraLimits& limits, RoiSteps steps) {
  const auto refuse = [&](const std::string& why) {
    return fail(Errc::invalid, "camera.roi",
                "a region of " + std::to_string(wanted.width) + " x " +
                    std::to_string(wanted.height) + " at (" + std::to_string(wanted.x) + ", " +
                    std::to_string(wanted.y) + ") " + why);
  };
  if (!lies_on_sensor(wanted.x, wanted.width, limits.sensor_width) ||
      !lies_on_sensor(wanted.y, wanted.height, limits.sensor_height))
    return refuse("does not lie on the sensor, which has " + std::to_string(limits.sensor_width) +
                  " x " + std::to_string(limits.sensor_height) + " pixels");
  if (wanted.width < limits.roi_width.min || wanted.height < limits.roi_height.min)
    return refuse("is too small; this camera accepts widths of " + describe(limits.roi_width) +
                  " and heights of " + describe(limits.roi_height));
  if ((steps.x == 0 && wanted.x != 0) || (steps.y == 0 && wanted.y != 0))
    return refuse("is not possible: this camera cannot move its region, x and y must be 0");

  Roi fitted;
  fitted.x = steps.x > 0 ? wanted.x / steps.x * steps.x : 0;
  fitted.y = steps.y > 0 ? wanted.y / steps.y * steps.y : 0;
  fitted.width = fit_extent(wanted.width, limits.roi_width);
  fitted.height = fit_extent(wanted.height, limits.roi_height);
  return fitted;
}

Result<void> check_pixel_format(PixelFormat wanted, const CameraLimits& limits) {
  const auto& formats = limits.pixel_formats;
  if (std::find(formats.begin(), formats.end(), wanted) != formats.end()) return {};
  std::string names;
  for (PixelFormat format : formats)
    names += (names.empty() ? "" : ", ") + std::string(pixel_format_name(format));
  return fail(Errc::invalid, "camera.pixel_format",
              "this camera has no " + std::string(pixel_format_name(wanted)) + "; it has " + names);
}

Result<void> check_region_suits_format(PixelFormat format, const Roi& roi) {
  const int group = pixels_per_group(format);
  const bool filtered = traits_of(format).filter != ColourFilter::none;
  if (filtered && (roi.x % 2 != 0 || roi.y % 2 != 0)) {
    return fail(Errc::invalid, "camera.roi",
                "a region that begins at an odd x or y would shift the colour filters of " +
                    std::string(pixel_format_name(format)) + ": both must be even");
  }
  if (roi.width % group == 0) return {};
  return fail(Errc::invalid, "camera.roi",
              "rows of " + std::string(pixel_format_name(format)) +
                  " would end within a byte with a width of " + std::to_string(roi.width) +
                  " pixels; the width must be a multiple of " + std::to_string(group));
}

Result<void> check_exposure_fits_rate(const CameraSettings& wanted, const CameraSettings& current) {
  const double period_us = 1e6 / wanted.frame_rate_hz;
  if (!(period_us > 0.0 && wanted.exposure_us > period_us * (1.0 + 1e-9))) return {};
  const bool by_exposure = wanted.exposure_us != current.exposure_us;
  return fail(Errc::invalid, by_exposure ? "camera.exposure_us" : "camera.frame_rate_hz",
              "an exposure of " + describe(wanted.exposure_us) + " us is longer than the " +
                  describe(period_us) + " us between two frames at " +
                  describe(wanted.frame_rate_hz) + " Hz; shorten it, or lower the frame rate");
}

bool has_unrequested_change(const CameraSettings& wanted, const CameraSettings& before,
                            const CameraSettings& applied) {
  const bool same_times =
      wanted.exposure_us == before.exposure_us && wanted.frame_rate_hz == before.frame_rate_hz;
  return (wanted.roi == before.roi && applied.roi != before.roi) ||
         (wanted.pixel_format == before.pixel_format &&
          applied.pixel_format != before.pixel_format) ||
         (same_gain(wanted, before) && !same_gain(applied, before)) ||
         (same_times && (applied.exposure_us != before.exposure_us ||
                         applied.frame_rate_hz != before.frame_rate_hz));
}

}  // namespace ovws
