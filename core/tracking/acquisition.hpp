/// Finds every spot in one image without history, and tells which belongs to which subaperture.
#pragma once

#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Memory for one image size, made off the frame path.
class Acquisition {
 public:
  Acquisition(SpotModel spots, std::vector<Vec2> predicted_px, int image_width, int image_height);

  /// Candidates are found over the whole image and assigned by a smooth-wavefront consensus:
  /// displacements from `predicted_px` are fitted by an affine map (tilt, focus, astigmatism), so
  /// that they may exceed half the pitch. Each start is then verified by `tracker`; what fails is
  /// lost. Writes one fix per subaperture and returns how many were found. RT-safe, but takes
  /// milliseconds.
  int acquire(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
              std::span<SpotFix> out) OVWS_NONBLOCKING;

 private:
  SpotModel spots_;
  std::vector<Vec2> predicted_px_;
  int image_width_;
  int image_height_;
};

}  // namespace ovws
