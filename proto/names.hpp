/// Names of enumerations on the wire and in the configuration.
#pragma once

#include <string>
#include <vector>

#include "core/base/pixel_format.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"
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
inline constexpr NamesOf kNames<ZernikeNorm> = texts<"rms", "unit">;
template <>
inline constexpr NamesOf kNames<TemplateKind> = texts<"model", "reference">;
template <>
inline constexpr NamesOf kNames<OperatorKind> = texts<"slopes", "diffractive", "measured">;
template <>
inline constexpr NamesOf kNames<PixelFormat> = []() -> const std::vector<std::string>& {
  static const auto names = [] {
    std::vector<std::string> all;
    for (const PixelFormatTraits& format : all_pixel_formats()) all.emplace_back(format.name);
    return all;
  }();
  return names;
};
/// Tracker name of older versions. In settings it means `fit` with kFormerEstimates numbers from
/// each spot, unless `estimates` is given. Recorded plans of this tracker are refused.
inline constexpr std::string_view kFormerTracker = "matched";
constexpr int kFormerEstimates = 2;
/// Names of all trackers, then kFormerTracker.
template <>
inline constexpr NamesOf kNames<TrackerKind> = []() -> const std::vector<std::string>& {
  static const auto names = [] {
    std::vector<std::string> all(all_tracker_names().begin(), all_tracker_names().end());
    all.emplace_back(kFormerTracker);
    return all;
  }();
  return names;
};
template <>
inline TrackerKind named(std::size_t name) {
  return name < all_tracker_names().size() ? TrackerKind(name) : TrackerKind::fit;
}

}  // namespace ovws
