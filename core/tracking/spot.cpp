#include "core/tracking/spot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

namespace ovws {
namespace {

constexpr float kFaint = 0.1F;  // level of a faint spot, share of the median level

constexpr std::array<std::string_view, 6> kNames{"centroid",   "thresholded", "weighted",
                                                 "lg_contour", "lg",          "fit"};

}  // namespace

int drop_faint(std::span<SpotFix> spots, int expected, std::span<const float> units) {
  const auto level_of = [&](std::size_t i) {
    return units.empty() ? spots[i].level : spots[i].level / units[i];
  };
  std::array<float, 4096> levels;
  std::size_t found = 0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (spots[i].found() && found < levels.size()) levels[found++] = level_of(i);
  }
  if (found == 0) return 0;
  const std::size_t middle = std::min(found, std::size_t(std::max(1, expected))) / 2;
  std::nth_element(levels.begin(), levels.begin() + middle, levels.begin() + found,
                   std::greater<>());
  int remain = 0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    SpotFix& spot = spots[i];
    if (!spot.found()) continue;
    if (level_of(i) >= kFaint * levels[middle]) {
      ++remain;
    } else {
      spot = SpotFix{.peak = spot.peak};
    }
  }
  return remain;
}

std::span<const std::string_view> all_tracker_names() {
  return kNames;
}

std::string_view tracker_name(TrackerKind kind) {
  return kNames[std::size_t(kind)];
}

std::optional<TrackerKind> tracker_from_name(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return TrackerKind(found - kNames.begin());
}

double lg_kernel_radius(const TrackingConfig& config, int charge) {
  return config.kernel_radius * std::sqrt(std::max(1, std::abs(charge)));
}

}  // namespace ovws
