/// Field tables of the camera.
#pragma once

#include "core/port/camera.hpp"
#include "proto/field_json.hpp"
#include "proto/names.hpp"

namespace ovws {

template <>
inline constexpr auto kTable<Roi> =
    Fields{"Roi", field<&Roi::x>("left edge, sensor pixels", limits::kRoiOffset),
           field<&Roi::y>("top edge, sensor pixels", limits::kRoiOffset),
           field<&Roi::width>("width, sensor pixels", limits::kRoiSize),
           field<&Roi::height>("height, sensor pixels", limits::kRoiSize)};

template <>
inline constexpr auto kTable<CameraSettings> = Fields{
    "CameraSettings",
    field<&CameraSettings::pixel_format>(
        "GenICam name; with a Bayer format only the pixels whose filter passes the laser are used"),
    field<&CameraSettings::exposure_us>("exposure time, microseconds", limits::kExposureUs),
    field<&CameraSettings::gain_db>("analogue gain, dB; null: the camera has no gain in dB",
                                    limits::kGainDb)
        .or_null(),
    field<&CameraSettings::gain_raw>(
        "gain in device-specific steps, if the camera has no gain in dB; otherwise null",
        limits::kGainRaw)
        .or_null(),
    field<&CameraSettings::frame_rate_hz>("frames per second", limits::kFrameRateHz),
    field<&CameraSettings::roi>("region of interest of the sensor")};
template <>
struct Rules<CameraSettings> {
  /// Refuses a change of both gain_db and gain_raw, because a camera has only one of the two. Null
  /// leaves a gain unchanged, because reports contain null for the gain that a camera lacks.
  static void check_change(ObjectReader& reader) {
    const auto gives = [&reader](const char* key) {
      return reader.has(key) && !reader.is_null(key);
    };
    if (gives("gain_db") && gives("gain_raw")) {
      reader.fault("gain_raw",
                   "cannot be set together with gain_db: set only the one that camera.get reports");
    }
  }
  /// Clears gain_raw if gain_db is given, and vice versa: a camera has its gain in one unit only.
  static void begin_change(CameraSettings& settings, const Json& given) {
    if (!given.value("gain_db", Json()).is_null()) settings.gain_raw = kUnknownGain;
    if (!given.value("gain_raw", Json()).is_null()) settings.gain_db = kUnknownGain;
  }
};

template <class T>
inline constexpr auto kTable<Range<T>> =
    Fields{std::is_integral_v<T> ? "WholeRange" : "Range", field<&Range<T>::min>("smallest"),
           field<&Range<T>::max>("largest"), field<&Range<T>::increment>("step; 0: continuous")};

template <>
inline constexpr auto kTable<CameraLimits> = Fields{
    "CameraLimits",
    computed(
        "gain_db",
        [](auto& limits) { return limits.gain_raw ? std::nullopt : std::optional(limits.gain_db); },
        "gain, dB; null: the camera has no gain in dB"),
    field<&CameraLimits::gain_raw>(
        "gain in device-specific steps, if the camera has no gain in dB; otherwise null"),
    field<&CameraLimits::exposure_us>("exposure time, microseconds"),
    field<&CameraLimits::frame_rate_hz>("frames per second"),
    field<&CameraLimits::roi_width>("width of the region, sensor pixels"),
    field<&CameraLimits::roi_height>("height of the region, sensor pixels"),
    field<&CameraLimits::sensor_width>("width of the sensor, sensor pixels", Bounds::at_least(0)),
    field<&CameraLimits::sensor_height>("height of the sensor, sensor pixels", Bounds::at_least(0)),
    field<&CameraLimits::pixel_formats>("pixel formats that both camera and daemon support")};

template <>
inline constexpr auto kTable<CameraInfo> =
    Fields{"CameraInfo", field<&CameraInfo::vendor>("manufacturer"),
           field<&CameraInfo::model>("model"), field<&CameraInfo::serial>("serial number"),
           field<&CameraInfo::address>("network address or bus, empty if unknown")};

/// Result of `camera.get`. `info` and `limits` are empty while no camera is connected.
struct CameraReport {
  std::optional<CameraInfo> info;
  CameraSettings settings;
  std::optional<CameraLimits> limits;
};
template <>
inline constexpr auto kTable<CameraReport> =
    Fields{"CameraReport",
           computed(
               "connected", [](auto& report) { return report.info.has_value(); },
               "whether a camera is connected"),
           field<&CameraReport::info>("identity of the camera"),
           field<&CameraReport::settings>("the camera's settings"),
           field<&CameraReport::limits>("current limits of the connected camera")};

/// Result of the `camera.auto_exposure` job.
struct AutoExposureReport {
  double exposure_us = 0.0, gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  double brightest = 0.0;
  int saturated_pixels = 0;
  int looks = 0;
};
template <>
inline constexpr auto kTable<AutoExposureReport> = Fields{
    "AutoExposureReport",
    field<&AutoExposureReport::exposure_us>("exposure time in use, microseconds"),
    field<&AutoExposureReport::gain_db>("gain in use, dB; null: the camera has no gain in dB")
        .or_null(),
    field<&AutoExposureReport::gain_raw>("gain in use in the camera's own steps, or null")
        .or_null(),
    field<&AutoExposureReport::brightest>(
        "brightness that most spots reach: the 80th percentile of the brightest pixels of the "
        "spots, fraction of full scale",
        {0, 1}),
    field<&AutoExposureReport::saturated_pixels>(
        "number of pixels that were at full scale in one of the frames", Bounds::at_least(0)),
    field<&AutoExposureReport::looks>("number of images that were judged", Bounds::at_least(1))};

}  // namespace ovws
