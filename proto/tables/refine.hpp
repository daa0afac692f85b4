/// Field table of the refinement's settings.
#pragma once

#include "proto/field_json.hpp"
#include "proto/refine_setup.hpp"
#include "proto/tables/names.hpp"

namespace ovws {

template <>
struct Table<RefineSetup> {
  static constexpr const char* kName = "RefineSetup";
  static constexpr auto kFields = Fields{
      field("enabled", &RefineSetup::enabled, "whether frames are refined"),
      field("rate_hz", &RefineSetup::rate_hz, "maximum number of frames to refine per second",
            limits::kRefineRateHz),
      field("electrons_per_dn", &RefineSetup::electrons_per_dn,
            "electrons per DN of the current pixel format at a gain of 0 dB; null: unknown, and "
            "frames cannot be refined",
            limits::kElectronsPerDn),
      field("read_noise_e", &RefineSetup::read_noise_e,
            "read noise of a pixel, electrons RMS; quantisation noise is added",
            limits::kReadNoiseE),
      field("black_level_dn", &RefineSetup::black_level_dn, "level of a dark pixel, DN",
            limits::kBlackLevelDn),
      field("saturation_dn", &RefineSetup::saturation_dn,
            "pixels at or above this level are not used, DN; null: the full scale of the pixel "
            "format",
            limits::kSaturationDn),
      field("spot_amplitudes", &RefineSetup::spot_amplitudes,
            "kept for older clients: the amplitude of each subaperture is always fitted")};
};

/// Result of `refine.get`. Numbers in DN are those of the pixel format stated with them.
struct RefineReport {
  RefineSetup settings;
};
template <>
struct Table<RefineReport> {
  static constexpr const char* kName = "RefineReport";
  static constexpr auto kFields =
      Fields{inlined(&RefineReport::settings),
             computed<RefineReport>(
                 "pixel_format", [](const RefineReport& report) { return report.settings.format; },
                 "the camera's pixel format, to which all DN refer")};
};

}  // namespace ovws
