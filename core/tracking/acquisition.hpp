/// Acquisition: finds every spot in one image without history and assigns it to a subaperture.
#pragma once

#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/candidates.hpp"
#include "core/tracking/spot_assignment.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Its memory is allocated at construction, for one image size: construct it off the frame path.
class Acquisition {
 public:
  Acquisition(SpotModel spots, const std::vector<Vec2>& predicted_px, int image_width,
              int image_height);

  /// Finds candidates in the whole image, verifies them with `tracker` and assigns those that pass
  /// to subapertures (SpotAssignment). The assignment fits the displacements from `predicted_px` by
  /// an affine map (tilt, focus, astigmatism), so that they may exceed half the pitch. It then
  /// searches missing spots where their neighbours predict them. Spots that fail are lost.
  ///
  /// Writes one fix per subaperture and returns how many were found: 0, or at least 3 and half of
  /// them. An image of another size gives 0. RT-safe, but takes milliseconds.
  int acquire(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
              std::span<SpotFix> out) OVWS_NONBLOCKING;

  /// Positions of the spots in the last image, image pixels: first the verified ones, then bright
  /// candidates that the tracker rejected. Empty if the image had another size.
  std::vector<Vec2> seen() const;

 private:
  void verify(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch);
  SpotFix search_where_expected(int i, const ImageView& image, const SpotTracker& tracker,
                                TrackScratch& scratch) const;
  bool taken(Vec2 at, std::span<const SpotFix> fixes) const;

  SpotModel spots_;
  int image_width_;
  int image_height_;
  CandidateFinder candidates_;
  SpotAssignment assignment_;
  std::vector<SpotFix> verified_;
  std::vector<Vec2> positions_;   ///< of verified_
  std::span<const Vec2> bright_;  ///< candidates of the last image
};

}  // namespace ovws
