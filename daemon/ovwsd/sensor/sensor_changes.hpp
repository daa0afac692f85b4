/// Changes of the sensor, to be passed to SensorKeeper::edit.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/optics/hologram.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"
#include "daemon/ovwsd/sensor/sensor_edit.hpp"
#include "proto/tables/params.hpp"

namespace ovws {

/// Method `sensor.set`. Errc::invalid: the tracker cannot separate the spots or is too slow to run
/// on every frame, or the spots do not determine `mode_count` modes. Errc::refused, field
/// "operator": `measured` was requested, but no calibration applies. A change that names a mask's
/// file takes its map from the mask in use, or from `read_masks` (none: that of the configuration).
SensorChange set_sensor(SensorSet change, std::optional<Masks> read_masks = std::nullopt);
/// As set_sensor, but the spots are not checked (check_spots): with a mask or `mode_count` this
/// renders them, which takes up to a second. For a sensor that has a reference.
SensorChange set_unchecked_sensor(SensorSet change, std::optional<Masks> read_masks = std::nullopt);
SensorChange set_aberration(std::vector<Mode> modes);
/// Shows a DMD's sequence: patterns of the sensor, each with these modes, in place of the
/// introduced aberration.
SensorChange set_sequence(std::vector<std::vector<Mode>> patterns, PatternCycle cycle);
SensorChange set_correction(std::vector<Mode> modes);
SensorChange show_pattern(HologramKind pattern);

/// Draws an image of the SLM's size.
using Painter = std::function<void(const HologramRenderer&, Image<std::uint8_t>&)>;
/// Hologram that a job shows: the sensor with `aberration` introduced, or the image that `paint`
/// draws.
struct ShowRequest {
  std::vector<Mode> aberration;
  Painter paint;       ///< empty: show the sensor
  SensorSet sensor{};  ///< settings of sensor and tracking to change
};
SensorChange show_request(ShowRequest what);

// Results of jobs: the following changes activate and store a result. `sensor_epoch`: the epoch
// when the job began. Errc::refused, field "camera", if the epoch has changed since.

/// Result of taking a reference: averaged spots, and the mean image (null: none).
struct TakenReference {
  /// The only source whose reference is taken, kMainBeam or a name; empty: all.
  std::string only;
  SpotAverage average;
  std::vector<SpotAverage> beams;  ///< of the further sources, as configured
  std::shared_ptr<const ReferenceImage> picture;
  CameraSettings settings;  ///< camera settings of the averaged frames
};
// The changes that make a reference active also return the errors of check_array_found;
// use_saved_reference returns them with field "name".

/// Makes a measured reference active. Adds the lost and weak spots of each source that was taken to
/// `spots` before that, in the order of TakenReference.
/// Errors: those of check_average, judge_spots and check_branch_points; Errc::refused, field
/// "camera", if the camera's settings have changed since the frames were taken; for a further
/// source alone also Errc::refused, field "beam": the main one has no measured reference. What is
/// not taken stays.
SensorChange use_reference(std::uint64_t sensor_epoch, TakenReference taken,
                           std::shared_ptr<std::vector<ReferenceSpots>> spots);
/// Model reference: positions computed from the registration, or else from the configuration.
SensorChange use_model_reference();
/// `reference.give`: makes a client's positions the reference of the main source, without an image;
/// those of further sources stay.
/// `given`: `found` is the number of frames or 0 (lost). Errors: Errc::refused, field "tracker":
/// the tracker is `fit`; Errc::invalid, field "positions": they do not fit the sensor; those of
/// judge_spots and check_branch_points.
SensorChange use_given_reference(SpotAverage given);
/// Makes a registration active, with plates that `use_plate` has set. A map that equals the active
/// one within their noise only renews its time: whatever was measured with it stays in use.
SensorChange use_registration(Registration registration);
/// `array.fit`: puts measured spiral plates into the active registration of a fixed array.
SensorChange use_plate(std::uint64_t sensor_epoch, const SpiralPlate& plate);
/// Makes a calibration active and selects the operator `measured`. Show a hologram without a poke
/// first, because its checksum is recorded in the calibration's origin.
SensorChange use_calibration(std::uint64_t sensor_epoch, MeasuredCalibration measured);
/// `calibration.set`: makes a client's matrix the calibration, as `use_calibration`. `bytes` are
/// the float32 of the binary frame. Errors: Errc::invalid, fields "shape", "modes" and "matrix":
/// they contradict the sensor or each other, or a number is not finite; Errc::refused, field
/// "tracker": the tracker is `fit`; those of interaction_matrix.
SensorChange give_calibration(CalibrationSet given, std::string bytes);
SensorChange use_lut(MeasuredLut lut);
SensorChange use_flatness(std::uint64_t sensor_epoch, MeasuredFlatness flatness);
/// `reference.load`: makes a saved reference the active one; its origin and time stay.
/// Errc::refused, field "name": it does not fit the present sensor.
SensorChange use_saved_reference(Reference reference);

// Deletions: the following changes delete the data that applies to the current sensor, in memory
// and on disk. If the files cannot be removed, the change is undone and the request fails.
SensorChange forget_reference();
SensorChange forget_registration();
SensorChange forget_calibration();
SensorChange forget_lut();
SensorChange forget_flatness();

}  // namespace ovws
