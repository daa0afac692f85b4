/// Field tables of wavefronts given as Zernike modes.
#pragma once

#include <cstdint>
#include <vector>

#include "core/optics/zernike.hpp"
#include "proto/field_json.hpp"
#include "proto/names.hpp"

namespace ovws {

inline constexpr const char* kModeIndexMeaning = "OSA/ANSI index";
inline constexpr const char* kHologramIdMeaning =
    "number of the hologram, as in every stream message; 0: none";

template <>
inline constexpr auto kTable<Mode> =
    Fields{"Mode", field<&Mode::j>(kModeIndexMeaning, Bounds(0, kMaxZernikeIndex)),
           field<&Mode::waves>("coefficient, RMS-normalised waves")};

/// A Zernike mode with its orders n and m and its common name.
struct NamedMode {
  Mode mode;
};
template <>
inline constexpr auto kTable<NamedMode> = Fields{
    "NamedMode",
    computed("j", [](auto& named) { return named.mode.j; }, kModeIndexMeaning,
             {0, kMaxZernikeIndex}),
    computed(
        "n", [](auto& named) { return zernike_index(named.mode.j).n; }, "radial order"),
    computed(
        "m", [](auto& named) { return zernike_index(named.mode.j).m; },
        "azimuthal frequency; negative: sine"),
    computed(
        "name", [](auto& named) { return zernike_name(named.mode.j); }, "common name, or Z(n,m)"),
    computed(
        "waves", [](auto& named) { return named.mode.waves; },
        "coefficient, waves RMS at the laser's wavelength")};

/// Result of `aberration.*` and `correction.*`.
struct ModesReport {
  std::vector<NamedMode> modes;
  std::uint64_t hologram_id = 0;

  ModesReport() = default;
  ModesReport(const std::vector<Mode>& of, std::uint64_t shown) : hologram_id(shown) {
    for (const Mode& mode : of) modes.push_back({mode});
  }
};
template <>
inline constexpr auto kTable<ModesReport> =
    Fields{"ModesReport",
           field<&ModesReport::modes>(
               "modes of the wavefront that is added or subtracted, RMS-normalised"),
           constant("norm", "rms", "normalisation of the coefficients"),
           field<&ModesReport::hologram_id>(kHologramIdMeaning)};

/// One pattern of a DMD's sequence.
struct PatternReport {
  std::vector<NamedMode> modes;
};
template <>
inline constexpr auto kTable<PatternReport> =
    Fields{"PatternReport", field<&PatternReport::modes>("modes introduced by this pattern")};

/// Result of `aberration.*`.
struct AberrationReport : ModesReport {
  std::vector<PatternReport> patterns;  ///< of a DMD's sequence; empty: none is shown

  AberrationReport() = default;
  AberrationReport(const std::vector<Mode>& of, const std::vector<std::vector<Mode>>& sequence,
                   std::uint64_t shown)
      : ModesReport(of, shown) {
    for (const std::vector<Mode>& pattern : sequence) {
      patterns.push_back({ModesReport(pattern, shown).modes});
    }
  }
};
template <>
inline constexpr auto kTable<AberrationReport> = Fields{
    "AberrationReport", based<ModesReport>(),
    field<&AberrationReport::patterns>(
        "patterns of the DMD's sequence, in the order of their numbers; empty: none is shown")};

}  // namespace ovws
