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
      field("rate_hz", &RefineSetup::rate_hz, "at most so many frames a second are refined",
            limits::kRefineRateHz),
      field("electrons_per_dn", &RefineSetup::electrons_per_dn,
            "electrons of one DN of the pixel format in use, at a gain of 0 dB; null: not known, "
            "and nothing can be refined",
            limits::kElectronsPerDn),
      field("read_noise_e", &RefineSetup::read_noise_e,
            "electrons RMS of a pixel; the rounding to whole DN is added", limits::kReadNoiseE),
      field("black_level_dn", &RefineSetup::black_level_dn, "DN of a dark pixel",
            limits::kBlackLevelDn),
      field("saturation_dn", &RefineSetup::saturation_dn,
            "pixels from here on are not used; null: the full scale of the pixel format",
            limits::kSaturationDn),
      field("spot_amplitudes", &RefineSetup::spot_amplitudes,
            "whether each subaperture's amplitude is fitted, too: uneven light")};
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
                 "the camera's, whose DN these are")};
};

}  // namespace ovws
