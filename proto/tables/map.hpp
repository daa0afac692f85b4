/// Field tables of map.run: the wavefront error of the bench as a fine map over the pupil.
#pragma once

#include <cstdint>
#include <string>

#include "proto/field.hpp"
#include "proto/limits.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

/// A map over the pupil's square, SLM axes.
struct PupilPicture {
  int cells = 0;
  std::string base64;  ///< little-endian float32 waves, row by row; NaN outside the pupil
};
template <>
inline constexpr auto kTable<PupilPicture> =
    Fields{"PupilPicture",
           field<&PupilPicture::cells>("rows and columns, which the pupil's circle touches",
                                       limits::kMapCells)
               .mandatory(),
           field<&PupilPicture::base64>(
               "waves in base64, little-endian float32, row by row; NaN outside the pupil")
               .mandatory()};

/// Result of the `map.run` job.
struct MapReport {
  std::int64_t t_taken_ns = 0;
  int patterns = 0, frames = 0;
  double exposure_us = 0.0, seconds = 0.0;
  double pupil_diameter_px = 0.0;
  double cell_px = 0.0, resolution_px = 0.0;
  double misfit = 0.0, standard_error_waves = 0.0;
  double rms_waves = 0.0, flatness_rms_waves = 0.0, difference_rms_waves = 0.0;
  bool applied = false;
  PupilPicture map, flatness;
};
template <>
inline constexpr auto kTable<MapReport> = Fields{
    "MapReport",
    field<&MapReport::t_taken_ns>(kTimeMeaning),
    time_text("t_taken", &MapReport::t_taken_ns),
    field<&MapReport::patterns>("number of patterns shown", Bounds::at_least(1)),
    field<&MapReport::frames>("number of frames averaged for each image; a pattern has two images",
                              Bounds::at_least(1)),
    field<&MapReport::exposure_us>("exposure of the frames, microseconds", Bounds::at_least(0)),
    field<&MapReport::seconds>("duration of the phase retrieval, s", Bounds::at_least(0)),
    field<&MapReport::pupil_diameter_px>("diameter of the mapped circle, SLM pixels",
                                         Bounds::at_least(0)),
    field<&MapReport::cell_px>("pitch of the retrieved map, SLM pixels", Bounds::at_least(0)),
    field<&MapReport::resolution_px>(
        "half period of the finest structure that both images of each pattern show alike "
        "(correlation at least 0.5), SLM pixels; at least cell_px. A smooth wavefront has no fine "
        "structure",
        Bounds::at_least(0)),
    field<&MapReport::misfit>("what the map leaves unexplained of the images' amplitudes, "
                              "relative RMS, noise included",
                              Bounds::at_least(0)),
    field<&MapReport::standard_error_waves>(
        "RMS error of a cell by noise, from the difference of both images of each pattern, waves",
        Bounds::at_least(0)),
    field<&MapReport::rms_waves>(
        "RMS over the pupil of the error, with that which the flatness in use removes, waves",
        Bounds::at_least(0)),
    field<&MapReport::flatness_rms_waves>(
        "RMS of the error that the measured flatness in use removes, waves; 0: there is none",
        Bounds::at_least(0)),
    field<&MapReport::difference_rms_waves>("RMS of the difference of both, waves",
                                            Bounds::at_least(0)),
    field<&MapReport::applied>("whether the map is the flatness in use from now on"),
    field<&MapReport::map>("the error of the light and the SLM, without piston and tilts"),
    field<&MapReport::flatness>("the part of it that the measured flatness in use removes")};

}  // namespace ovws
