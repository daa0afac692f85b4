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

/// `sensor.set`. Errc::invalid: the tracker cannot separate the spots, or is too slow to run on
/// every frame. Errc::refused, field "operator": `measured` was requested, but no calibration
/// applies.
SensorChange set_sensor(SensorSet change);
SensorChange set_aberration(std::vector<Mode> modes);
SensorChange set_correction(std::vector<Mode> modes);
SensorChange show_pattern(HologramKind pattern);

/// Draws an image of the SLM's size.
using Painter = std::function<void(const HologramRenderer&, Image<std::uint8_t>&)>;
/// What a job shows: the sensor with these modes introduced, or the image that `paint` draws.
struct ShowRequest {
  std::vector<Mode> aberration;
  Painter paint;       ///< none: show the sensor
  SensorSet sensor{};  ///< settings of sensor and tracking to change
};
SensorChange show_request(ShowRequest what);
/// Restores what was shown before the job began.
SensorChange restore_previous();

// These activate and store the result of a job. `sensor_epoch`: that of the job's start.
// Errc::refused, field "camera", if the sensor or the camera's image has changed since.

/// Averaged spots, and the mean image (null: none).
struct TakenReference {
  SpotAverage average;
  std::shared_ptr<const ReferenceImage> picture;
  CameraSettings settings;  ///< settings that the frames were taken with
};
/// Writes the classified spots to `spots` before the change is active. Errors: those of
/// check_average and judge_spots; Errc::refused, field "camera", if the camera's settings have
/// changed since.
SensorChange use_reference(std::uint64_t sensor_epoch, TakenReference taken,
                           std::shared_ptr<ReferenceSpots> spots);
/// Model reference: positions computed from the registration, or else from the configuration.
SensorChange use_model_reference();
SensorChange use_registration(Registration registration);
/// Also selects the operator `measured`. The hologram shown must be one without a poke.
SensorChange use_calibration(std::uint64_t sensor_epoch, MeasuredCalibration measured);
SensorChange use_lut(MeasuredLut lut);
SensorChange use_flatness(std::uint64_t sensor_epoch, MeasuredFlatness flatness);

// These delete what applies to the current sensor, in memory and on disk. If the files cannot be
// removed, the change is undone and the request fails.
SensorChange forget_reference();
SensorChange forget_registration();
SensorChange forget_calibration();
SensorChange forget_lut();
SensorChange forget_flatness();

}  // namespace ovws
