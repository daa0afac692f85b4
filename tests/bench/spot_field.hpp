/// A picture full of spots, one a region, for timing.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws::bench {

/// `count` regions of `region_px` x `region_px` side by side, a noisy spot of the charge a few
/// pixels off the middle of each; lambda/d is 12.5 px for 64, and in proportion.
struct SpotField {
  SpotField(int count, int region_px, int charge);

  SpotModel spots;
  int region_px = 64;
  std::vector<Vec2> middles_px;  ///< of the regions: where a tracker starts
  Image<std::uint16_t> picture;  ///< 12 significant bits
  ImageView view() const { return view_of(picture, PixelFormat::mono16); }
};

/// The yardstick: one pass of a plain thresholded centroid over each region. Returns the sum of all
/// positions, so that nothing is left out.
double centroid_mark(const SpotField& field);

}  // namespace ovws::bench
