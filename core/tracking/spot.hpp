/// The fix of one spot (SpotFix), the list of trackers, and the tracking configuration.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "core/base/realtime.hpp"

namespace ovws {

/// Fix of one spot in one frame, camera pixels of the ROI. A lost spot has NaN coordinates and
/// quality 0.
struct SpotFix {
  float x = std::numeric_limits<float>::quiet_NaN();
  float y = std::numeric_limits<float>::quiet_NaN();
  float peak = 0.0F;     ///< brightest pixel of the spot's window, camera units (DN)
  float quality = 0.0F;  ///< [0,1]: contrast of the spot against its surroundings; 0 = lost
  float level = 0.0F;  ///< mean of the spot's bright part above its local background, DN; 0 = lost
  float noise = 0.0F;  ///< RMS pixel noise around the spot, DN; 0 = not measured

  bool found() const { return !std::isnan(x); }
};

/// Marks a faint spot as lost: its level is below a tenth of the median level of the `expected`
/// brightest spots. Returns the number of spots that remain. In a dark subaperture, stray light of
/// other spots forms genuine but faint vortices; only the level distinguishes a faint vortex from a
/// spot. RT-safe; the median uses at most 4096 spots.
/// `units`: level of each spot at equal light, see SpotKinds; empty: the spots are of one kind.
int drop_faint(std::span<SpotFix> spots, int expected,
               std::span<const float> units = {}) OVWS_NONBLOCKING;

enum class TrackerKind : std::uint8_t {
  centroid,
  thresholded,
  weighted,
  lg_contour,
  lg,
  fit,  ///< fits all pixels of the spots (core/spots); the positions are those of `lg`
};

/// Names of all trackers, in the order of TrackerKind.
std::span<const std::string_view> all_tracker_names();
std::string_view tracker_name(TrackerKind kind);
std::optional<TrackerKind> tracker_from_name(std::string_view name);

struct TrackingConfig {
  TrackerKind tracker = TrackerKind::fit;
  double kernel_radius = 0.3;  ///< LG kernel's 1/e radius w in units of lambda/d on the camera

  friend bool operator==(const TrackingConfig&, const TrackingConfig&) = default;
};

/// The LG kernel's 1/e radius for a charge l, units of lambda/d: kernel_radius sqrt(max(1, |l|)).
/// Aberration splits a core of charge l into |l| single cores. The wider kernel gives one minimum,
/// at the mean of the single cores.
double lg_kernel_radius(const TrackingConfig& config, int charge);

}  // namespace ovws
