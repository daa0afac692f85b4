/// Field tables of the result of focus.run: the aberrations of the whole pupil, and the camera's
/// distance from the focus.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/vec2.hpp"
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
               "standard error, from the residual of the fit, waves", Bounds::at_least(0))};

/// The dark core of the vortex with its axis at one place.
struct FocusCore {
  Vec2 axis;
  std::optional<Vec2> core_px;
};
template <>
inline constexpr auto kTable<FocusCore> =
    Fields{"FocusCore",
           field<&FocusCore::axis>("place of the vortex's axis in the pupil [x, y], pupil radii"),
           field<&FocusCore::core_px>(
               "place of the dark core [x, y], camera pixels; null: there is none near the spot")};

/// Result of the `focus.run` job.
struct FocusReport {
  std::int64_t t_taken_ns = 0;
  int frames = 0;
  int images = 0;
  int rounds = 0;
  double pupil_diameter_px = 0.0;
  double defocus_waves = 0.0, defocus_standard_error_waves = 0.0;
  double camera_shift_mm = 0.0, camera_shift_standard_error_mm = 0.0;
  std::optional<double> flatness_defocus_waves;
  std::vector<FocusMode> modes;
  double change_rms_waves = 0.0;
  Vec2 middle_px;
  std::vector<FocusCore> path;
  double motion_px = 0.0;
  double exposure_us = 0.0;
};
template <>
inline constexpr auto kTable<FocusReport> = Fields{
    "FocusReport",
    field<&FocusReport::t_taken_ns>(kTimeMeaning),
    time_text("t_taken", &FocusReport::t_taken_ns),
    field<&FocusReport::frames>("number of frames averaged for each image", Bounds::at_least(1)),
    field<&FocusReport::images>("number of images of the vortex", Bounds::at_least(1)),
    field<&FocusReport::rounds>("number of rounds until the modes no longer changed",
                                Bounds::at_least(1)),
    field<&FocusReport::pupil_diameter_px>(
        "diameter of the circle over which the modes are normalised, SLM pixels",
        Bounds::at_least(0)),
    field<&FocusReport::defocus_waves>("coefficient of defocus (j = 4), RMS-normalised waves"),
    field<&FocusReport::defocus_standard_error_waves>(
        "its standard error, from the residual of the fit, waves", Bounds::at_least(0)),
    field<&FocusReport::camera_shift_mm>(
        "distance of the camera from the focus that this defocus amounts to, millimetres; "
        "positive: the camera is behind the focus, farther from the lens. Move it back by this"),
    field<&FocusReport::camera_shift_standard_error_mm>("its standard error, millimetres",
                                                        Bounds::at_least(0)),
    field<&FocusReport::flatness_defocus_waves>(
        "defocus that the measured flatness in use compensates, RMS-normalised waves; it is not in "
        "the result. Null: no flatness is measured"),
    field<&FocusReport::modes>(
        "modes of the light, beyond the flatness in use: j = 3 to 14, without tilts"),
    field<&FocusReport::change_rms_waves>(
        "change of the modes in the last round, root sum square, waves", Bounds::at_least(0)),
    field<&FocusReport::middle_px>(
        "place of the beam without a vortex [x, y], camera pixels of the region"),
    field<&FocusReport::path>("path of the vortex's dark core in the last round, with the modes "
                              "compensated and without the "
                              "motion of the beam"),
    field<&FocusReport::motion_px>("RMS motion of the beam from image to image, camera pixels: "
                                   "vibration and drift, which do not "
                                   "mislead the modes",
                                   Bounds::at_least(0)),
    field<&FocusReport::exposure_us>("exposure of the images of the vortex, microseconds",
                                     Bounds::at_least(0))};

}  // namespace ovws
