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

/// Acquisition for one lattice and one image size. The constructor allocates all memory: call it
/// off the frame path.
class Acquisition {
 public:
  Acquisition(SpotModel spots, const std::vector<Vec2>& predicted_px, int image_width,
              int image_height);

  /// Finds candidate spots in the whole image, verifies each with `tracker` and assigns the
  /// verified spots to subapertures (SpotAssignment). Displacements from `predicted_px` may exceed
  /// half the pitch, because the assignment fits them by an affine map (tilt, focus, astigmatism).
  /// Missing spots are searched where their neighbours predict them. Spots that fail are lost.
  ///
  /// Writes one fix per subaperture to `out` and returns the number of spots found. With fewer than
  /// 3 spots, or fewer than half of the subapertures, every fix is lost and the result is 0. An
  /// image of another size also gives 0. RT-safe, but takes milliseconds.
  int acquire(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
              std::span<SpotFix> out) OVWS_NONBLOCKING;

  /// Positions of the spots in the last image, camera pixels: first the verified spots, then bright
  /// candidates that the tracker rejected. Empty if the last image had another size.
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
  std::vector<Vec2> positions_;   ///< positions of the spots in verified_, camera pixels
  std::span<const Vec2> bright_;  ///< candidates of the last image
};

}  // namespace ovws
