/// Field tables of sensor.advise.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "proto/field_json.hpp"
#include "proto/limits.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

/// Params of `sensor.advise`.
struct SensorAdvise {
  int modes = 0;
  double photo_electrons_per_s = 0.0;
  double full_well_e = 10'000.0;
  double read_noise_e = 5.0;
  std::optional<double> longest_us;
};
template <>
inline constexpr auto kTable<SensorAdvise> = Fields{
    "SensorAdvise",
    field<&SensorAdvise::modes>("number of Zernike modes that are wanted", limits::kAdvisedModes)
        .mandatory(),
    field<&SensorAdvise::photo_electrons_per_s>(
        "photo-electrons per second that the light on the whole pupil gives on the camera",
        limits::kPhotoElectronsPerS)
        .mandatory(),
    field<&SensorAdvise::full_well_e>("full well of a pixel, electrons", limits::kFullWellE),
    field<&SensorAdvise::read_noise_e>("read noise, electrons", limits::kReadNoiseE),
    field<&SensorAdvise::longest_us>(
        "longest exposure, microseconds; null: the interval of the present frame rate",
        limits::kExposureUs)};

/// A sensor that measures the modes, with its expected error.
struct AdvisedSensor {
  int subapertures_across = 0, subapertures = 0, charge = 0;
  std::array<double, 2> grooves{};
  double spacing = 0.0;
  double exposure_us = 0.0, peak_e = 0.0;
  double error_waves = 0.0, worst_mode_waves = 0.0;
  std::string limited_by;
};
template <>
inline constexpr auto kTable<AdvisedSensor> = Fields{
    "AdvisedSensor",
    field<&AdvisedSensor::subapertures_across>("for sensor.set", limits::kSubaperturesAcross),
    field<&AdvisedSensor::charge>("for sensor.set", limits::kCharge),
    field<&AdvisedSensor::grooves>("for sensor.set", limits::kGrooves),
    field<&AdvisedSensor::spacing>("for sensor.set", Bounds::at_least(0)),
    field<&AdvisedSensor::subapertures>("number of subapertures", Bounds::at_least(1)),
    field<&AdvisedSensor::exposure_us>("for camera.set, microseconds", Bounds::at_least(0)),
    field<&AdvisedSensor::peak_e>("in the brightest pixel, electrons", Bounds::at_least(0)),
    field<&AdvisedSensor::error_waves>(
        "standard error of one frame: root of the sum of squares over the modes without tilts, "
        "RMS-normalised waves",
        Bounds::at_least(0)),
    field<&AdvisedSensor::worst_mode_waves>("largest standard error of a mode, waves",
                                            Bounds::at_least(0)),
    field<&AdvisedSensor::limited_by>(
        "what limits the exposure: the light (exposure time), or the brightest pixel (full well)")
        .among(texts<"exposure time", "full well">)};

struct UnfitSensor {
  int subapertures_across = 0, charge = 0;
  std::string reason;
};
template <>
inline constexpr auto kTable<UnfitSensor> =
    Fields{"UnfitSensor",
           field<&UnfitSensor::subapertures_across>("subapertures across the pupil",
                                                    limits::kSubaperturesAcross),
           field<&UnfitSensor::charge>("charge", limits::kCharge),
           field<&UnfitSensor::reason>("why it does not measure the modes on this bench")};

/// Result of the `sensor.advise` job.
struct SensorAdvice {
  std::vector<AdvisedSensor> best_first;
  std::vector<UnfitSensor> unfit;
};
template <>
inline constexpr auto kTable<SensorAdvice> =
    Fields{"SensorAdvice",
           field<&SensorAdvice::best_first>("sensors that measure the modes, smallest error first"),
           field<&SensorAdvice::unfit>("sensors that do not")};

}  // namespace ovws
