/// How the port's settings are found, checked, written in an order that cameras accept, and undone.
#include "drivers/aravis/features.hpp"

#include <initializer_list>
#include <string>
#include <utility>

namespace ovws {

namespace {

/// Names the setting at fault; the device only knows its features' names.
template <class T>
Result<T> at(const char* field, Result<T> result) {
  if (!result) result.error().field = field;
  return result;
}

Range<int> whole(const Range<double>& range, int sensor) {
  const int min = int(range.min);
  const int step = range.increment > 1.0 ? int(range.increment) : 1;
  // The camera's own maximum shrinks with the offset in use; what counts is the sensor.
  return {min, min + (sensor - min) / step * step, step};
}

}  // namespace

Result<CameraFeatures> CameraFeatures::find(GenicamDevice& device) {
  CameraFeatures found(device);
  const auto pick = [&](const char*& slot, std::initializer_list<const char*> names) {
    for (const char* name : names)
      if (device.has_number(name)) {
        slot = name;
        return true;
      }
    return false;
  };
  const auto lacks = [](const char* field, const char* what) {
    return fail(Errc::device, field, std::string("this camera has no feature ") + what);
  };
  if (!pick(found.gain_, {"Gain", "GainAbs", "GainRaw"})) return lacks("camera.gain_db", "Gain");
  if (!pick(found.exposure_, {"ExposureTime", "ExposureTimeAbs"}))
    return lacks("camera.exposure_us", "ExposureTime");
  if (!pick(found.rate_, {"AcquisitionFrameRate", "AcquisitionFrameRateAbs"}))
    return lacks("camera.frame_rate_hz", "AcquisitionFrameRate");
  // With binning, WidthMax is what a region must fit into, and SensorWidth is not.
  if (!pick(found.sensor_width_, {"WidthMax", "SensorWidth"}) ||
      !pick(found.sensor_height_, {"HeightMax", "SensorHeight"}))
    return lacks("camera.roi", "WidthMax, HeightMax, SensorWidth or SensorHeight");
  return found;
}

Result<void> CameraFeatures::turn_triggers_off() {
  if (!device_->has("TriggerMode")) return {};
  if (!device_->has("TriggerSelector")) return device_->choose_if_offered("TriggerMode", "Off");
  auto selectors = device_->choices("TriggerSelector");
  if (!selectors) return fail(selectors.error());
  for (const std::string& selector : *selectors) {
    if (auto done = device_->set_text("TriggerSelector", selector.c_str()); !done) return done;
    if (auto done = device_->choose_if_offered("TriggerMode", "Off"); !done) return done;
  }
  return {};
}

Result<void> CameraFeatures::choose_a_known_pixel_format() {
  auto now = device_->text("PixelFormat");
  if (!now) return at<void>("camera.pixel_format", fail(now.error()));
  if (pixel_format_from_name(*now)) return {};
  auto offered = device_->choices("PixelFormat");
  if (!offered) return at<void>("camera.pixel_format", fail(offered.error()));
  std::string names;
  for (const std::string& name : *offered) {
    if (pixel_format_from_name(name)) return device_->set_text("PixelFormat", name.c_str());
    names += (names.empty() ? "" : ", ") + name;
  }
  return fail(Errc::device, "camera.pixel_format",
              "this camera has no unpacked monochrome format; it has " + names);
}

Result<void> CameraFeatures::prepare() {
  static constexpr std::pair<const char*, const char*> kChoices[] = {
      {"AcquisitionMode", "Continuous"}, {"GainAuto", "Off"},
      {"ExposureAuto", "Off"},           {"ExposureMode", "Timed"},
      {"BlackLevelAuto", "Off"},         {"AcquisitionFrameRateAuto", "Off"}};
  static constexpr std::pair<const char*, bool> kSwitches[] = {
      {"AcquisitionFrameRateEnable", true},
      {"AcquisitionFrameRateEnabled", true},
      {"GammaEnable", false},
      {"ChunkModeActive", false}};
  for (const auto& [feature, choice] : kChoices)
    if (auto done = device_->choose_if_offered(feature, choice); !done) return done;
  for (const auto& [feature, on] : kSwitches)
    if (auto done = device_->switch_if_there(feature, on); !done) return done;
  if (auto done = turn_triggers_off(); !done) return done;
  return choose_a_known_pixel_format();
}

CameraInfo CameraFeatures::info(const std::string& address) {
  const auto text = [&](const char* feature) {
    return device_->has(feature) ? device_->text(feature).value_or("") : std::string();
  };
  CameraInfo info;
  info.vendor = text("DeviceVendorName");
  info.model = text("DeviceModelName");
  info.serial = text("DeviceSerialNumber");
  if (info.serial.empty()) info.serial = text("DeviceID");
  info.address = address;
  return info;
}

Result<CameraLimits> CameraFeatures::limits() {
  CameraLimits limits;
  const auto value = [&](const char* feature, auto& out) -> Result<void> {
    auto number = device_->number(feature);
    if (!number) return fail(number.error());
    out = std::decay_t<decltype(out)>(*number);
    return {};
  };
  const auto range = [&](const char* feature, Range<double>& out) -> Result<void> {
    auto answer = device_->range(feature);
    if (!answer) return fail(answer.error());
    out = *answer;
    return {};
  };
  Range<double> width, height;
  if (auto r = range(gain_, limits.gain_db); !r) return fail(r.error());
  if (auto r = range(exposure_, limits.exposure_us); !r) return fail(r.error());
  if (auto r = range(rate_, limits.frame_rate_hz); !r) return fail(r.error());
  if (auto r = value(sensor_width_, limits.sensor_width); !r) return fail(r.error());
  if (auto r = value(sensor_height_, limits.sensor_height); !r) return fail(r.error());
  if (auto r = range("Width", width); !r) return fail(r.error());
  if (auto r = range("Height", height); !r) return fail(r.error());
  limits.roi_width = whole(width, limits.sensor_width);
  limits.roi_height = whole(height, limits.sensor_height);
  auto formats = device_->choices("PixelFormat");
  if (!formats) return fail(formats.error());
  for (const std::string& name : *formats)
    if (auto format = pixel_format_from_name(name)) limits.pixel_formats.push_back(*format);
  return limits;
}

Result<CameraSettings> CameraFeatures::read() {
  CameraSettings settings;
  auto format = device_->text("PixelFormat");
  if (!format) return at<CameraSettings>("camera.pixel_format", fail(format.error()));
  const auto known = pixel_format_from_name(*format);
  if (!known)
    return fail(Errc::device, "camera.pixel_format", "the camera has gone over to " + *format);
  settings.pixel_format = *known;

  Result<void> all;
  const auto take = [&](const char* field, const char* feature, auto& out) {
    if (!all) return;
    if (auto number = at(field, device_->number(feature)); number)
      out = std::decay_t<decltype(out)>(*number);
    else
      all = fail(number.error());
  };
  take("camera.gain_db", gain_, settings.gain_db);
  take("camera.exposure_us", exposure_, settings.exposure_us);
  take("camera.frame_rate_hz", rate_, settings.frame_rate_hz);
  take("camera.roi", "Width", settings.roi.width);
  take("camera.roi", "Height", settings.roi.height);
  if (device_->has_number("OffsetX")) take("camera.roi", "OffsetX", settings.roi.x);
  if (device_->has_number("OffsetY")) take("camera.roi", "OffsetY", settings.roi.y);
  if (!all) return fail(all.error());
  return settings;
}

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
  if (auto known = check_pixel_format(wanted.pixel_format, *now); !known)
    return fail(known.error());
  auto roi = fit_roi(wanted.roi, *now, *steps);
  if (!roi) return fail(roi.error());
  fitted.roi = *roi;
  auto gain = fit_value("camera.gain_db", "a gain", wanted.gain_db, now->gain_db);
  if (!gain) return fail(gain.error());
  fitted.gain_db = *gain;
  // The ranges of exposure and rate are checked when they are set, because they may depend on each
  // other. Only if the two exclude each other is the better reason looked for here.
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

Result<CameraSettings> CameraFeatures::apply(const CameraSettings& wanted,
                                             const CameraSettings& current, bool streaming) {
  auto fitted = fit(wanted, current);
  if (!fitted) return fitted;
  const bool same_frame =
      fitted->roi == current.roi && fitted->pixel_format == current.pixel_format;
  if (streaming && !same_frame)
    return fail(Errc::refused, fitted->roi == current.roi ? "camera.pixel_format" : "camera.roi",
                "the size of a frame cannot change while frames are coming; stop first");
  Undo undo;
  if (auto done = write(*fitted, current, undo); !done) {
    for (auto step = undo.rbegin(); step != undo.rend(); ++step) (*step)();
    return fail(done.error());
  }
  return read();
}

Result<void> CameraFeatures::write(const CameraSettings& wanted, const CameraSettings& current,
                                   Undo& undo) {
  // The size of a frame first, because the fastest rate depends on it. Of the rate and the
  // exposure, which on many cameras limit each other, the one that makes room for the other.
  if (wanted.pixel_format != current.pixel_format) {
    const auto set = [this](PixelFormat format) {
      return at("camera.pixel_format",
                device_->set_text("PixelFormat", std::string(pixel_format_name(format)).c_str()));
    };
    undo.emplace_back([=] { (void)set(current.pixel_format); });
    if (auto done = set(wanted.pixel_format); !done) return done;
  }
  if (wanted.roi != current.roi) {
    undo.emplace_back([this, roi = current.roi] { (void)write_roi(roi); });
    if (auto done = at("camera.roi", write_roi(wanted.roi)); !done) return done;
  }
  if (wanted.gain_db != current.gain_db) {
    undo.emplace_back([=, this] { (void)device_->set_number(gain_, current.gain_db); });
    if (auto done = at("camera.gain_db", device_->set_number(gain_, wanted.gain_db)); !done)
      return done;
  }
  if (wanted.frame_rate_hz < current.frame_rate_hz) {
    if (auto done = write_rate(wanted, current, undo); !done) return done;
    return write_exposure(wanted, current, undo);
  }
  if (auto done = write_exposure(wanted, current, undo); !done) return done;
  return write_rate(wanted, current, undo);
}

Result<void> CameraFeatures::write_roi(const Roi& roi) {
  const auto axis = [&](const char* offset, const char* extent, int begin,
                        int length) -> Result<void> {
    const bool movable = device_->has_number(offset);
    // At offset 0 every extent is allowed; where it was, perhaps not.
    if (movable)
      if (auto done = device_->set_number(offset, 0); !done) return done;
    if (auto done = device_->set_number(extent, length); !done) return done;
    return movable ? device_->set_number(offset, begin) : Result<void>();
  };
  if (auto done = axis("OffsetX", "Width", roi.x, roi.width); !done) return done;
  return axis("OffsetY", "Height", roi.y, roi.height);
}

Result<void> CameraFeatures::write_exposure(const CameraSettings& wanted,
                                            const CameraSettings& current, Undo& undo) {
  const char* field = "camera.exposure_us";
  auto range = at(field, device_->range(exposure_));
  if (!range) return fail(range.error());
  auto value = fit_value(field, "an exposure", wanted.exposure_us, *range);
  if (!value) return fail(value.error());
  if (*value == current.exposure_us) return {};
  undo.emplace_back([=, this] { (void)device_->set_number(exposure_, current.exposure_us); });
  return at(field, device_->set_number(exposure_, *value));
}

Result<void> CameraFeatures::write_rate(const CameraSettings& wanted, const CameraSettings& current,
                                        Undo& undo) {
  const char* field = "camera.frame_rate_hz";
  auto range = at(field, device_->range(rate_));
  if (!range) return fail(range.error());
  auto value = fit_value(field, "a frame rate", wanted.frame_rate_hz, *range);
  if (!value) return fail(value.error());
  if (*value == current.frame_rate_hz) return {};
  undo.emplace_back([=, this] { (void)device_->set_number(rate_, current.frame_rate_hz); });
  return at(field, device_->set_number(rate_, *value));
}

}  // namespace ovws
