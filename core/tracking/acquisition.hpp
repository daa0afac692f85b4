/// Finds every spot in one image without history, and tells which belongs to which subaperture.
#pragma once

#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/candidates.hpp"
#include "core/tracking/consensus.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Memory for one image size, made off the frame path.
class Acquisition {
 public:
  Acquisition(SpotModel spots, const std::vector<Vec2>& predicted_px, int image_width,
              int image_height);

  /// Candidates are found over the whole image and verified by `tracker`; those that pass are
  /// assigned by a smooth-wavefront consensus: displacements from `predicted_px` are fitted by an
  /// affine map (tilt, focus, astigmatism), so that they may exceed half the pitch. A subaperture
  /// that got none is looked for where its neighbours say. What fails is lost; an image of another
  /// size has nothing. Writes one fix per subaperture and returns how many were found: 0, or at
  /// least 3 and half of them. RT-safe, but takes milliseconds.
  int acquire(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
              std::span<SpotFix> out) OVWS_NONBLOCKING;

  /// Where the image of the last `acquire` had spots, or what may be some that the tracker refuses:
  /// image pixels, the verified first. None if it was of another size.
  std::vector<Vec2> seen() const;

 private:
  void verify(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch);
  SpotFix look_where_expected(int i, const ImageView& image, const SpotTracker& tracker,
                              TrackScratch& scratch) const;
  void look_again(int i, const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
                  SpotFix& fix) const;
  bool taken(Vec2 at, std::span<const SpotFix> fixes) const;

  SpotModel spots_;
  int image_width_;
  int image_height_;
  CandidateFinder candidates_;
  Consensus consensus_;
  std::vector<SpotFix> verified_;
  std::vector<Vec2> positions_;   ///< of verified_
  std::span<const Vec2> bright_;  ///< candidates of the last image
};

}  // namespace ovws
