/// Field tables of a measurement's origin: the bench and settings that it was made with.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/wavefront/registration.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/optics.hpp"
#include "proto/tables/sensor.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

/// Identity of a camera, independent of its address.
struct CameraName {
  std::string vendor, model, serial;
};
template <>
inline constexpr auto kTable<CameraName> =
    Fields{"CameraName", field<&CameraName::vendor>("manufacturer"),
           field<&CameraName::model>("model"), field<&CameraName::serial>("serial number")};

/// Identity of the SLM: its geometry, and checksums of the look-up table and the flatness map.
/// They, the sensor and the modes determine the grey levels of a hologram.
struct SlmIdentity {
  SlmGeometry geometry;
  std::optional<std::string> lut_sha256, flatness_sha256;
};
template <>
inline constexpr auto kTable<SlmIdentity> =
    Fields{"SlmIdentity", inlined(&SlmIdentity::geometry),
           field<&SlmIdentity::lut_sha256>(
               "SHA-256 of the look-up table's 256 grey levels; null: no table"),
           field<&SlmIdentity::flatness_sha256>(
               "SHA-256 of the flatness map's float32 waves; null: no map")};

/// Camera settings that hardly affect spot positions. A change of these settings makes a reference
/// stale, but the reference stays active.
struct OriginSettings {
  CameraSettings camera;
};
template <>
inline constexpr auto kTable<OriginSettings> = Fields{
    "OriginSettings",
    computed(
        "gain_db", [](auto& s) { return s.camera.gain_db; },
        "analogue gain, dB; null: the camera has no gain in dB")
        .or_null(),
    computed(
        "gain_raw", [](auto& s) { return s.camera.gain_raw; },
        "gain in device-specific steps, only of a camera without gain in dB")
        .or_left_out(),
    computed(
        "exposure_us", [](auto& s) { return s.camera.exposure_us; }, "exposure time, microseconds"),
    computed(
        "pixel_format", [](auto& s) { return s.camera.pixel_format; }, "GenICam name")};

struct OriginRegistration {
  std::int64_t t_taken_ns = 0;
  Vec2 base_px;
  PxPerCycle px_per_cycle;
};
template <>
inline constexpr auto kTable<OriginRegistration> =
    Fields{"OriginRegistration", field<&OriginRegistration::t_taken_ns>(kTimeMeaning),
           field<&OriginRegistration::base_px>(
               "[x, y] of the base spot, pixels of the camera's sensor", {-1e6, 1e6}),
           field<&OriginRegistration::px_per_cycle>(
               "[xx, xy, yx, yy]: camera pixels per cycle per SLM pixel", limits::kPxPerCycle)};

/// Bench and settings that a reference or calibration was taken with; also stored in its file.
struct Origin {
  std::string program;
  std::optional<CameraName> camera;
  std::optional<OriginSettings> settings;
  std::optional<OriginRegistration> registration;
  Roi roi;
  SensorConfig sensor;
  JsonObject tracking;
  JsonOf<OpticsConfig> optics;
  JsonOf<SlmIdentity> slm;
  std::vector<Mode> aberration, introduced;
  std::optional<std::string> hologram_sha256;
};
template <>
inline constexpr auto kTable<Origin> =
    Fields{"Origin",
           field<&Origin::program>("version of the daemon"),
           field<&Origin::camera>("identity of the camera; null: unknown"),
           field<&Origin::settings>("settings of the camera; null: unknown"),
           field<&Origin::registration>(
               "registration that was active; null: none, the configuration's map was used"),
           field<&Origin::roi>("as in camera.set"),
           field<&Origin::sensor>("as in the configuration"),
           field<&Origin::tracking>("as in the configuration"),
           field<&Origin::optics>("as in the configuration"),
           field<&Origin::slm>("the spatial light modulator"),
           field<&Origin::aberration>(
               "modes shown on purpose, corrections included, RMS-normalised waves"),
           field<&Origin::introduced>(
               "`aberration` without the correction; the key is left out if nothing was introduced")
               .or_left_out(),
           field<&Origin::hologram_sha256>("SHA-256 of the shown hologram's grey levels, row by "
                                           "row; null: the reference is the model's")};

}  // namespace ovws
