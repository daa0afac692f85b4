/// Field table of the refinement's settings.
#pragma once

#include "core/control/refine_settings.hpp"
#include "proto/field_json.hpp"
#include "proto/names.hpp"

namespace ovws {

template <>
inline constexpr auto kTable<RefineSetup> = Fields{
    "RefineSetup",
    field<&RefineSetup::enabled>("whether frames are refined"),
    field<&RefineSetup::rate_hz>("maximum number of frames to refine per second",
                                 limits::kRefineRateHz),
    field<&RefineSetup::electrons_per_dn>("electrons per DN of the current pixel format at a gain "
                                          "of 0 dB; null: unknown, and frames cannot be refined",
                                          limits::kElectronsPerDn),
    field<&RefineSetup::read_noise_e>(
        "read noise of a pixel, electrons RMS; quantisation noise is added", limits::kReadNoiseE),
    field<&RefineSetup::black_level_dn>("level of a dark pixel, DN", limits::kBlackLevelDn),
    field<&RefineSetup::saturation_dn>(
        "pixels at or above this level are not used, DN; null: the full scale of the pixel format",
        limits::kSaturationDn)};

/// Result of `refine.get`. Values in DN refer to the pixel format that the result states.
struct RefineReport {
  RefineSetup settings;
};
template <>
inline constexpr auto kTable<RefineReport> =
    Fields{"RefineReport", inlined(&RefineReport::settings),
           computed(
               "pixel_format", [](auto& report) { return report.settings.format; },
               "the camera's pixel format, to which all DN refer")};

}  // namespace ovws
