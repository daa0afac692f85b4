/// The changes of the sensor, for SensorKeeper::edit.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/optics/hologram.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"
#include "daemon/ovwsd/sensor/sensor_edit.hpp"
#include "proto/tables/params.hpp"

namespace ovws {

/// `sensor.set`. Errc::invalid for a sensor whose spots the tracker cannot tell apart, or which is
/// too slow to run; Errc::refused, field "operator": there is no calibration to read modes with.
SensorChange set_sensor(SensorSet change);
SensorChange set_aberration(std::vector<Mode> modes);
SensorChange set_correction(std::vector<Mode> modes);
SensorChange show_pattern(HologramKind pattern);

/// Draws a picture of the SLM's size.
using Painter = std::function<void(const HologramRenderer&, Image<std::uint8_t>&)>;
/// What a job shows: the sensor with these modes for an aberration, or what `paint` draws.
struct ShowRequest {
  std::vector<Mode> aberration;
  Painter paint;       ///< none: the sensor
  SensorSet sensor{};  ///< what of it, and of its tracking, is otherwise from now on
};
SensorChange show_request(ShowRequest what);
/// What was shown before the job began is shown again.
SensorChange give_back();

// What a job measured is active from now on, and kept. `sensor_epoch`: as the job began;
// Errc::refused, field "camera", if the sensor or its image is another one by now.

/// Spots averaged over frames, and their picture (null: none).
struct TakenReference {
  SpotAverage average;
  std::shared_ptr<const ReferencePicture> picture;
  CameraSettings settings;  ///< that they were taken with
};
/// `spots` is set before the change is active. Errors: those of check_average and judge_spots;
/// Errc::refused, field "camera", if the camera's settings are others by now.
SensorChange use_reference(std::uint64_t sensor_epoch, TakenReference taken,
                           std::shared_ptr<ReferenceSpots> spots);
/// Where the registration, or else the configuration, says that spots are.
SensorChange use_model_reference();
SensorChange use_registration(Registration registration);
/// The sensor is shown without a poke; modes are read with it.
SensorChange use_calibration(std::uint64_t sensor_epoch, MeasuredCalibration measured);
SensorChange use_lut(MeasuredLut lut);
SensorChange use_flatness(std::uint64_t sensor_epoch, MeasuredFlatness flatness);

// Of what belongs to the sensor as it is, on the disk, too. An error if it cannot be removed there,
// and then nothing has changed.
SensorChange forget_reference();
SensorChange forget_registration();
SensorChange forget_calibration();
SensorChange forget_lut();
SensorChange forget_flatness();

}  // namespace ovws
