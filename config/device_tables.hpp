/// Field tables of the device models.
#pragma once

#include "config/devices.hpp"
#include "proto/tables/optics.hpp"

namespace ovws {

template <>
inline constexpr auto kTable<SlmModel> =
    Fields{"SlmModel",
           field<&SlmModel::name>("name for --slm").mandatory(),
           inlined(&SlmModel::geometry),
           field<&SlmModel::settle_ms>("typical settle time, milliseconds", limits::kSettleMs),
           field<&SlmModel::confirmed>("whether a public document states size and pitch"),
           field<&SlmModel::source>("where the numbers are from").mandatory()};

template <>
inline constexpr auto kTable<CameraModel> = Fields{
    "CameraModel",
    field<&CameraModel::name>("name for --camera").mandatory(),
    field<&CameraModel::width>("width, pixels", limits::kRoiSize).mandatory(),
    field<&CameraModel::height>("height, pixels", limits::kRoiSize).mandatory(),
    field<&CameraModel::pitch_um>("pixel pitch, micrometres", limits::kCameraPitchUm).mandatory(),
    field<&CameraModel::confirmed>("whether a public document states size and pitch"),
    field<&CameraModel::source>("where the numbers are from").mandatory()};

template <>
inline constexpr auto kTable<Devices> =
    Fields{"Devices", field<&Devices::slms>("spatial light modulators"),
           field<&Devices::cameras>("camera sensors")};

}  // namespace ovws
