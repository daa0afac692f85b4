/// Camera settings: checks them, writes them in an order that cameras accept, and rolls back on an
/// error.
#include <cmath>
#include <string>
#include <utility>

#include "drivers/aravis/features.hpp"

namespace ovws {

Result<RoiSteps> CameraFeatures::roi_steps() {
  RoiSteps steps{0, 0};
  const auto step = [&](const char* feature, int& out) -> Result<void> {
    if (!device_->has_number(feature)) return {};
    auto range = device_->range(feature);
    if (!range) return fail(range.error());
    out = range->increment > 1.0 ? int(range->increment) : 1;
    return {};
  };
  if (auto done = step("OffsetX", steps.x); !done) return fail(done.error());
  if (auto done = step("OffsetY", steps.y); !done) return fail(done.error());
  return steps;
}

Result<CameraSettings> CameraFeatures::fit(const CameraSettings& wanted,
                                           const CameraSettings& current) {
  auto now = limits();
  if (!now) return fail(now.error());
  auto steps = roi_steps();
  if (!steps) return fail(steps.error());
  CameraSettings fitted = wanted;
  if (auto offered = check_pixel_format(wanted.pixel_format, *now); !offered)
    return fail(offered.error());
  auto roi = fit_roi(wanted.roi, *now, *steps);
  if (!roi) return fail(roi.error());
  fitted.roi = *roi;
  if (auto suits = check_region_suits_format(fitted.pixel_format, fitted.roi); !suits)
    return fail(suits.error());
  if (auto done = fit_gain(current, *now, fitted); !done) return fail(done.error());
  // Exposure and frame rate may limit each other's range, so their ranges are checked only when
  // they are written (write_time). But if the exposure exceeds the frame period, they are checked
  // here: an exposure that the camera can never have is reported as that, not as too long for the
  // rate.
  if (auto both = check_exposure_fits_rate(wanted, current); !both) {
    auto exposure =
        fit_value("camera.exposure_us", "an exposure", wanted.exposure_us, now->exposure_us);
    if (!exposure) return fail(exposure.error());
    auto rate =
        fit_value("camera.frame_rate_hz", "a frame rate", wanted.frame_rate_hz, now->frame_rate_hz);
    return fail(rate ? both.error() : rate.error());
  }
  return fitted;
}

/// Replaces the requested gain in `settings` by the gain to write: rounded, in the camera's unit.
Result<void> CameraFeatures::fit_gain(const CameraSettings& current, const CameraLimits& limits,
                                      CameraSettings& settings) const {
  const bool requested_db = !std::isnan(settings.gain_db) && settings.gain_db != 0.0;
  const bool requested_raw = !std::isnan(settings.gain_raw);
  if (gain_is_raw() && requested_db)
    return fail(Errc::invalid, "camera.gain_db",
                "this camera has no gain in dB, only in device-specific steps: set gain_raw");
  if (!gain_is_raw() && requested_raw)
    return fail(Errc::invalid, "camera.gain_raw", "this camera has its gain in dB: set gain_db");
  if (gain_is_raw()) settings.gain_db = kUnknownGain;
  double& gain = settings.*gain_.value;
  if (std::isnan(gain) && gain_is_raw()) gain = current.gain_raw;
  auto fitted =
      fit_value(gain_.field, gain_.what, gain, gain_is_raw() ? *limits.gain_raw : limits.gain_db);
  if (!fitted) return fail(fitted.error());
  gain = *fitted;
  return {};
}

Result<CameraSettings> CameraFeatures::apply(const CameraSettings& wanted,
                                             const CameraSettings& current, bool streaming) {
  auto fitted = fit(wanted, current);
  if (!fitted) return fitted;
  const bool same_frame =
      fitted->roi == current.roi && fitted->pixel_format == current.pixel_format;
  if (streaming && !same_frame)
    return fail(Errc::refused, fitted->roi == current.roi ? "camera.pixel_format" : "camera.roi",
                "the frame size cannot change while the camera is streaming; stop it first");
  Undo undo;
  auto applied = write_and_read(*fitted, current, undo);
  if (applied && streaming && has_unrequested_change(*fitted, current, *applied)) {
    device_->give_up();
    return fail(Errc::device, "", kCameraWasReset);
  }
  if (!applied && !undo.empty()) {
    for (auto step = undo.rbegin(); step != undo.rend(); ++step) (*step)();
    if (const auto now = read(); !now || *now != current) device_->give_up();
  }
  return applied;
}

/// Writes the settings and reads them back. Also checks the control privilege, because a camera
/// that was reset meanwhile answers with its power-up settings.
Result<CameraSettings> CameraFeatures::write_and_read(const CameraSettings& wanted,
                                                      const CameraSettings& current, Undo& undo) {
  if (auto done = write(wanted, current, undo); !done) return fail(done.error());
  auto applied = read();
  if (!applied) return applied;
  if (auto control = device_->check_control(); !control) return fail(control.error());
  return applied;
}

Result<void> CameraFeatures::write(const CameraSettings& wanted, const CameraSettings& current,
                                   Undo& undo) {
  // Write the frame size first, because the maximum frame rate depends on it. On many cameras
  // exposure and rate limit each other: a lower rate comes before the exposure, a higher one after.
  if (wanted.pixel_format != current.pixel_format) {
    const auto set = [this](PixelFormat format) {
      return at_field(
          "camera.pixel_format",
          device_->set_text("PixelFormat", std::string(pixel_format_name(format)).c_str()));
    };
    undo.emplace_back([=] { (void)set(current.pixel_format); });
    if (auto done = set(wanted.pixel_format); !done) return done;
  }
  if (wanted.roi != current.roi) {
    undo.emplace_back([this, roi = current.roi] { (void)write_roi(roi); });
    if (auto done = at_field("camera.roi", write_roi(wanted.roi)); !done) return done;
  }
  if (const double gain = wanted.*gain_.value, before = current.*gain_.value; gain != before) {
    undo.emplace_back([=, this] { (void)device_->set_number(gain_.feature, before); });
    if (auto done = at_field(gain_.field, device_->set_number(gain_.feature, gain)); !done)
      return done;
  }
  if (wanted.frame_rate_hz < current.frame_rate_hz) {
    if (auto done = write_time(rate_, wanted, current, undo); !done) return done;
    return write_time(exposure_, wanted, current, undo);
  }
  if (auto done = write_time(exposure_, wanted, current, undo); !done) return done;
  return write_time(rate_, wanted, current, undo);
}

Result<void> CameraFeatures::write_roi(const Roi& roi) {
  const auto axis = [&](const char* offset, const char* extent, int begin,
                        int length) -> Result<void> {
    const bool movable = device_->has_number(offset);
    // Set the offset to 0 first: the current offset may not leave room for the new extent.
    if (movable)
      if (auto done = device_->set_number(offset, 0); !done) return done;
    if (auto done = device_->set_number(extent, length); !done) return done;
    return movable ? device_->set_number(offset, begin) : Result<void>();
  };
  if (auto done = axis("OffsetX", "Width", roi.x, roi.width); !done) return done;
  return axis("OffsetY", "Height", roi.y, roi.height);
}

/// Writes the exposure or the frame rate, checked against its current range: exposure and rate may
/// limit each other.
Result<void> CameraFeatures::write_time(const Number& number, const CameraSettings& wanted,
                                        const CameraSettings& current, Undo& undo) {
  auto range = at_field(number.field, device_->range(number.feature));
  if (!range) return fail(range.error());
  auto value = fit_value(number.field, number.what, wanted.*number.value, *range);
  if (!value) return fail(value.error());
  const double before = current.*number.value;
  if (*value == before) return {};
  undo.emplace_back([=, this] { (void)device_->set_number(number.feature, before); });
  return at_field(number.field, device_->set_number(number.feature, *value));
}

}  // namespace ovws
