/// Synthetic image of many spots, one per region, for timing.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/spots/rendered_spot.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws::bench {

/// A grid of `count` regions of `region_px` x `region_px`, each with a noisy spot a few pixels off
/// its middle. lambda/d is proportional to region_px: 12.5 px for 64.
struct SpotField {
  SpotField(int count, int region_px, int charge);

  SpotModel spots;
  int region_px = 64;
  std::vector<Vec2> middles_px;  ///< centres of the regions: start positions of trackers
  Image<std::uint16_t> picture;  ///< 12 significant bits
  ImageView view() const { return view_of(picture, PixelFormat::mono16); }
};
constexpr double kPeakDn = 2000.0;  ///< of a spot, above the background

/// The spots as if rendered, in windows of 4 lambda/d, with derivatives for 18 modes that differ
/// from spot to spot.
std::vector<RenderedSpot> rendered(const SpotField& field);

/// Reference for timing: one pass of a thresholded centroid over each region, a plain loop built
/// with all that the compiler and this machine offer. Returns the sum of all positions, so that the
/// compiler cannot remove the work.
double centroid_mark(const SpotField& field);

}  // namespace ovws::bench
