#include "core/tracking/spot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

namespace ovws {
namespace {

constexpr float kFaint = 0.1F;  // of the median level

constexpr std::array<std::pair<TrackerKind, std::string_view>, 6> kNames{
    {{TrackerKind::centroid, "centroid"},
     {TrackerKind::thresholded, "thresholded"},
     {TrackerKind::weighted, "weighted"},
     {TrackerKind::lg_contour, "lg_contour"},
     {TrackerKind::lg, "lg"},
     {TrackerKind::matched, "matched"}}};

}  // namespace

int drop_faint(std::span<SpotFix> spots, int expected) {
  std::array<float, 4096> levels;
  std::size_t found = 0;
  for (const SpotFix& spot : spots) {
    if (spot.found() && found < levels.size()) levels[found++] = spot.level;
  }
  if (found == 0) return 0;
  const std::size_t middle = std::min(found, std::size_t(std::max(1, expected))) / 2;
  std::nth_element(levels.begin(), levels.begin() + middle, levels.begin() + found,
                   std::greater<>());
  int remain = 0;
  for (SpotFix& spot : spots) {
    if (!spot.found()) continue;
    if (spot.level >= kFaint * levels[middle]) {
      ++remain;
    } else {
      spot = SpotFix{.peak = spot.peak};
    }
  }
  return remain;
}

std::string_view tracker_name(TrackerKind kind) {
  for (const auto& [known, name] : kNames) {
    if (known == kind) return name;
  }
  return "";
}

std::optional<TrackerKind> tracker_from_name(std::string_view name) {
  for (const auto& [kind, known] : kNames) {
    if (known == name) return kind;
  }
  return std::nullopt;
}

double lg_kernel_radius(const TrackingConfig& config, int charge) {
  return config.kernel_radius * std::sqrt(std::max(1, std::abs(charge)));
}

}  // namespace ovws
