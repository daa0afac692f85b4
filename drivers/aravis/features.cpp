/// GenICam features of the camera port's settings: finds and reads them.
#include "drivers/aravis/features.hpp"

#include <algorithm>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/printable.hpp"

namespace ovws {

namespace {

Range<int> whole(const Range<double>& range, int sensor) {
  const int min = int(range.min);
  const int step = range.increment > 1.0 ? int(range.increment) : 1;
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
    return fail(Errc::device, field,
                "this camera has no feature " + std::string(what) + ": ovws cannot use it");
  };
  if (!pick(found.gain_.feature, {"Gain", "GainAbs"})) {
    if (!pick(found.gain_.feature, {"GainRaw"})) return lacks("camera.gain_db", "Gain");
    found.gain_.field = "camera.gain_raw";
    found.gain_.value = &CameraSettings::gain_raw;
  }
  if (!pick(found.exposure_.feature, {"ExposureTime", "ExposureTimeAbs"}))
    return lacks("camera.exposure_us", "ExposureTime");
  if (!pick(found.rate_.feature, {"AcquisitionFrameRate", "AcquisitionFrameRateAbs"}))
    return lacks("camera.frame_rate_hz", "AcquisitionFrameRate");
  if (!pick(found.sensor_width_, {"SensorWidth", "WidthMax"}) ||
      !pick(found.sensor_height_, {"SensorHeight", "HeightMax"}))
    return lacks("camera.roi", "SensorWidth, SensorHeight, WidthMax or HeightMax");
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

Result<void> CameraFeatures::use_trigger(const std::string& source) {
  const auto set = [&](const char* feature, const std::string& choice) -> Result<void> {
    if (!device_->has(feature))
      return fail(
          Errc::device, "camera.trigger",
          "this camera has no feature " + std::string(feature) + ": set camera.trigger to \"\"");
    auto offered = device_->choices(feature);
    if (!offered) return fail(Errc::device, "camera.trigger", offered.error().reason);
    std::string names;
    for (const std::string& name : *offered)
      names += (names.empty() ? "" : ", ") + printable(name, kMaxNameBytes);
    if (std::ranges::find(*offered, choice) == offered->end())
      return fail(Errc::invalid, "camera.trigger",
                  "\"" + printable(choice, kMaxNameBytes) + "\" is no " + feature +
                      " of this camera, which has " + names);
    return at_field<void>("camera.trigger", device_->set_text(feature, choice.c_str()));
  };
  if (device_->has("TriggerSelector")) {
    if (auto done = set("TriggerSelector", "FrameStart"); !done) return done;
  }
  if (auto done = set("TriggerSource", source); !done) return done;
  // An exposure may begin while the frame before is read out; else every second pulse may be
  // missed.
  for (const auto& [feature, choice] :
       {std::pair{"TriggerActivation", "RisingEdge"}, std::pair{"TriggerOverlap", "ReadOut"}}) {
    if (auto done = device_->choose_if_offered(feature, choice); !done) return done;
  }
  return set("TriggerMode", "On");
}

Result<void> CameraFeatures::choose_supported_pixel_format() {
  auto now = device_->text("PixelFormat");
  if (!now) return at_field<void>("camera.pixel_format", fail(now.error()));
  if (pixel_format_from_name(*now)) return {};
  auto offered = device_->choices("PixelFormat");
  if (!offered) return at_field<void>("camera.pixel_format", fail(offered.error()));
  std::string names;
  for (const std::string& name : *offered) {
    if (pixel_format_from_name(name)) return device_->set_text("PixelFormat", name.c_str());
    names += (names.empty() ? "" : ", ") + printable(name, kMaxNameBytes);
  }
  return fail(
      Errc::device, "camera.pixel_format",
      "ovws cannot use this camera: it has no supported monochrome or Bayer format, only " + names);
}

Result<void> CameraFeatures::prepare(const std::string& trigger) {
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
    if (auto done = device_->switch_if_offered(feature, on); !done) return done;
  if (auto done = turn_triggers_off(); !done) return done;
  if (!trigger.empty()) {
    if (auto done = use_trigger(trigger); !done) return done;
  }
  return choose_supported_pixel_format();
}

CameraInfo CameraFeatures::info(const std::string& address) {
  const auto text = [&](const char* feature) {
    return device_->has(feature) ? printable(device_->text(feature).value_or(""), kMaxNameBytes)
                                 : std::string();
  };
  CameraInfo info;
  info.vendor = text("DeviceVendorName");
  info.model = text("DeviceModelName");
  info.serial = text("DeviceSerialNumber");
  if (info.serial.empty()) info.serial = text("DeviceID");
  info.address = address;
  return info;
}

/// Usable sensor extent along one axis, pixels: a region must fit into it. Binning makes the extent
/// smaller than the sensor. Most cameras reduce the reported maximum by the current offset, so the
/// offset is added again.
Result<int> CameraFeatures::sensor_extent(const char* sensor, const char* extent,
                                          const char* offset) {
  auto pixels = device_->number(sensor);
  if (!pixels) return fail(pixels.error());
  auto range = device_->range(extent);
  if (!range) return fail(range.error());
  auto begin = device_->has_number(offset) ? device_->number(offset) : Result<double>(0.0);
  if (!begin) return fail(begin.error());
  return int(std::min(*pixels, range->max + *begin));
}

Result<CameraLimits> CameraFeatures::limits() {
  CameraLimits limits;
  Result<void> all;
  const auto take = [&](auto& out, auto answer) {
    if (all && answer) out = *answer;
    if (all && !answer) all = fail(answer.error());
  };
  Range<double> width, height;
  std::vector<std::string> formats;
  if (gain_is_raw()) limits.gain_raw.emplace();
  take(gain_is_raw() ? *limits.gain_raw : limits.gain_db, device_->range(gain_.feature));
  take(limits.exposure_us, device_->range(exposure_.feature));
  take(limits.frame_rate_hz, device_->range(rate_.feature));
  take(limits.sensor_width, sensor_extent(sensor_width_, "Width", "OffsetX"));
  take(limits.sensor_height, sensor_extent(sensor_height_, "Height", "OffsetY"));
  take(width, device_->range("Width"));
  take(height, device_->range("Height"));
  take(formats, device_->choices("PixelFormat"));
  if (!all) return fail(all.error());
  limits.roi_width = whole(width, limits.sensor_width);
  limits.roi_height = whole(height, limits.sensor_height);
  for (const std::string& name : formats)
    if (auto format = pixel_format_from_name(name)) limits.pixel_formats.push_back(*format);
  return limits;
}

Result<CameraSettings> CameraFeatures::read() {
  CameraSettings settings;
  auto format = device_->text("PixelFormat");
  if (!format) return at_field<CameraSettings>("camera.pixel_format", fail(format.error()));
  const auto supported = pixel_format_from_name(*format);
  if (!supported)
    return fail(
        Errc::device, "camera.pixel_format",
        "the camera has switched to the unsupported format " + printable(*format, kMaxNameBytes));
  settings.pixel_format = *supported;

  Result<void> all;
  const auto take = [&](const char* field, const char* feature, auto& out) {
    if (!all) return;
    if (auto number = at_field(field, device_->number(feature)); number)
      out = std::decay_t<decltype(out)>(*number);
    else
      all = fail(number.error());
  };
  settings.gain_db = kUnknownGain;
  for (const Number& number : {gain_, exposure_, rate_})
    take(number.field, number.feature, settings.*number.value);
  take("camera.roi", "Width", settings.roi.width);
  take("camera.roi", "Height", settings.roi.height);
  if (device_->has_number("OffsetX")) take("camera.roi", "OffsetX", settings.roi.x);
  if (device_->has_number("OffsetY")) take("camera.roi", "OffsetY", settings.roi.y);
  if (!all) return fail(all.error());
  return settings;
}

}  // namespace ovws
