/// Field tables of the camera.
#pragma once

#include "core/port/camera.hpp"
#include "proto/field_json.hpp"
#include "proto/tables/names.hpp"

namespace ovws {

template <>
struct Table<Roi> {
  static constexpr const char* kName = "Roi";
  static constexpr auto kFields =
      Fields{field("x", &Roi::x, "left edge, sensor pixels", limits::kRoiOffset),
             field("y", &Roi::y, "top edge, sensor pixels", limits::kRoiOffset),
             field("width", &Roi::width, "width, sensor pixels", limits::kRoiSize),
             field("height", &Roi::height, "height, sensor pixels", limits::kRoiSize)};
};

template <>
struct Table<CameraSettings> {
  static constexpr const char* kName = "CameraSettings";
  static constexpr auto kFields = Fields{
      field("pixel_format", &CameraSettings::pixel_format,
            "GenICam name; with a Bayer format only the pixels whose filter passes the laser are "
            "used"),
      field("exposure_us", &CameraSettings::exposure_us, "exposure time, microseconds",
            limits::kExposureUs),
      field("gain_db", &CameraSettings::gain_db,
            "analogue gain, dB; null: the camera has no gain in dB", limits::kGainDb)
          .or_null(),
      field("gain_raw", &CameraSettings::gain_raw,
            "gain in device-specific steps, if the camera has no gain in dB; otherwise null",
            limits::kGainRaw)
          .or_null(),
      field("frame_rate_hz", &CameraSettings::frame_rate_hz, "frames per second",
            limits::kFrameRateHz),
      field("roi", &CameraSettings::roi, "region of interest of the sensor")};

  /// Refuses a change of both gains, because a camera has only one of them. Null leaves a gain
  /// unchanged: the missing one is reported as null.
  static void check_change(ObjectReader& reader) {
    const auto gives = [&reader](const char* key) {
      return reader.has(key) && !reader.is_null(key);
    };
    if (gives("gain_db") && gives("gain_raw")) {
      reader.fault("gain_raw",
                   "cannot be set together with gain_db: set only the one that camera.get reports");
    }
  }
  /// Clears the other gain, because a camera has its gain in one unit only.
  static void begin_change(CameraSettings& settings, const Json& given) {
    if (!given.value("gain_db", Json()).is_null()) settings.gain_raw = kUnknownGain;
    if (!given.value("gain_raw", Json()).is_null()) settings.gain_db = kUnknownGain;
  }
};

template <class T>
struct Table<Range<T>> {
  static constexpr const char* kName = std::is_integral_v<T> ? "WholeRange" : "Range";
  static constexpr auto kFields =
      Fields{field("min", &Range<T>::min, "smallest"), field("max", &Range<T>::max, "largest"),
             field("increment", &Range<T>::increment, "step; 0: continuous")};
};

template <>
struct Table<CameraLimits> {
  static constexpr const char* kName = "CameraLimits";
  static constexpr auto kFields = Fields{
      computed<CameraLimits>(
          "gain_db",
          [](const CameraLimits& limits) {
            return limits.gain_raw ? std::nullopt : std::optional(limits.gain_db);
          },
          "gain, dB; null: the camera has no gain in dB"),
      field("gain_raw", &CameraLimits::gain_raw,
            "gain in device-specific steps, if the camera has no gain in dB; otherwise null"),
      field("exposure_us", &CameraLimits::exposure_us, "exposure time, microseconds"),
      field("frame_rate_hz", &CameraLimits::frame_rate_hz, "frames per second"),
      field("roi_width", &CameraLimits::roi_width, "width of the region, sensor pixels"),
      field("roi_height", &CameraLimits::roi_height, "height of the region, sensor pixels"),
      field("sensor_width", &CameraLimits::sensor_width, "width of the sensor, sensor pixels",
            Bounds::at_least(0)),
      field("sensor_height", &CameraLimits::sensor_height, "height of the sensor, sensor pixels",
            Bounds::at_least(0)),
      field("pixel_formats", &CameraLimits::pixel_formats,
            "pixel formats that both camera and daemon support")};
};

template <>
struct Table<CameraInfo> {
  static constexpr const char* kName = "CameraInfo";
  static constexpr auto kFields =
      Fields{field("vendor", &CameraInfo::vendor, "manufacturer"),
             field("model", &CameraInfo::model, "model"),
             field("serial", &CameraInfo::serial, "serial number"),
             field("address", &CameraInfo::address, "network address or bus, empty if unknown")};
};

/// Result of `camera.get`. `info` and `limits` are empty while no camera is connected.
struct CameraReport {
  std::optional<CameraInfo> info;
  CameraSettings settings;
  std::optional<CameraLimits> limits;
};
template <>
struct Table<CameraReport> {
  static constexpr const char* kName = "CameraReport";
  static constexpr auto kFields =
      Fields{computed<CameraReport>(
                 "connected", [](const CameraReport& report) { return report.info.has_value(); },
                 "whether a camera is connected"),
             field("info", &CameraReport::info, "identity of the camera"),
             field("settings", &CameraReport::settings, "the camera's settings"),
             field("limits", &CameraReport::limits, "current limits of the connected camera")};
};

}  // namespace ovws
