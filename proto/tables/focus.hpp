/// Field tables of the result of focus.run: the aberrations of the whole pupil, and the camera's
/// distance from the focus.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "proto/tables/modes.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

struct FocusMode {
  NamedMode named;
  double standard_error_waves = 0.0;
};
template <>
inline constexpr auto kTable<FocusMode> =
    Fields{"FocusMode", inlined(&FocusMode::named),
           field<&FocusMode::standard_error_waves>(
               "standard error, from the noise of the image, waves", Bounds::at_least(0))};

/// Result of the `focus.run` job.
struct FocusReport {
  std::int64_t t_taken_ns = 0;
  int frames = 0;
  double pupil_diameter_px = 0.0;
  double defocus_waves = 0.0, defocus_standard_error_waves = 0.0;
  double camera_shift_mm = 0.0, camera_shift_standard_error_mm = 0.0;
  std::optional<double> flatness_defocus_waves;
  std::vector<FocusMode> modes;
  double exposure_us = 0.0;
};
template <>
inline constexpr auto kTable<FocusReport> = Fields{
    "FocusReport",
    field<&FocusReport::t_taken_ns>(kTimeMeaning),
    time_text("t_taken", &FocusReport::t_taken_ns),
    field<&FocusReport::frames>("number of frames", Bounds::at_least(1)),
    field<&FocusReport::pupil_diameter_px>(
        "diameter of the circle over which the modes are normalised, SLM pixels",
        Bounds::at_least(0)),
    field<&FocusReport::defocus_waves>("coefficient of defocus (j = 4), RMS-normalised waves"),
    field<&FocusReport::defocus_standard_error_waves>(
        "its standard error, from the noise of the image, waves", Bounds::at_least(0)),
    field<&FocusReport::camera_shift_mm>(
        "distance of the camera from the focus that this defocus amounts to, millimetres; "
        "positive: the camera is behind the focus, farther from the lens. Move it back by this"),
    field<&FocusReport::camera_shift_standard_error_mm>("its standard error, millimetres",
                                                        Bounds::at_least(0)),
    field<&FocusReport::flatness_defocus_waves>(
        "defocus that the measured flatness in use compensates, RMS-normalised waves; it is not in "
        "the result. Null: no flatness is measured"),
    field<&FocusReport::modes>(
        "modes of the light, beyond the flatness in use: j = 3 to 14, as far "
        "as the places of the spots determine them"),
    field<&FocusReport::exposure_us>("exposure of the image, microseconds", Bounds::at_least(0))};

}  // namespace ovws
