/// Names of enumerations on the wire and in the configuration.
#pragma once

#include <string>
#include <vector>

#include "core/base/pixel_format.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"
#include "core/pipeline/verdict.hpp"
#include "core/tracking/tracker.hpp"
#include "proto/field.hpp"

namespace ovws {

template <>
inline constexpr NamesOf kNames<Grid> = texts<"hexagonal", "square">;
template <>
inline constexpr NamesOf kNames<HologramKind> =
    texts<"sensor", "grating", "flat", "identify", "test">;
/// Patterns that a user can select: all but `test`, which is reserved for jobs.
inline constexpr NamesOf kShowablePatterns = texts<"sensor", "grating", "flat", "identify">;
template <>
inline constexpr NamesOf kNames<Verdict> =
    texts<"valid", "late", "changing", "no_pattern", "other_hologram", "no_reference", "too_close",
          "undetermined", "branch_points", "unconfirmed", "unexplained", "spots_lost">;
template <>
inline constexpr NamesOf kNames<ZernikeNorm> = texts<"rms", "unit">;
template <>
inline constexpr NamesOf kNames<OperatorKind> = texts<"slopes", "measured">;
template <>
inline constexpr NamesOf kNames<PixelFormat> = []() -> const std::vector<std::string>& {
  static const auto names = [] {
    std::vector<std::string> all;
    for (const PixelFormatTraits& format : all_pixel_formats()) all.emplace_back(format.name);
    return all;
  }();
  return names;
};
template <>
inline constexpr NamesOf kNames<TrackerKind> = []() -> const std::vector<std::string>& {
  static const std::vector<std::string> names(all_tracker_names().begin(),
                                              all_tracker_names().end());
  return names;
};

}  // namespace ovws
