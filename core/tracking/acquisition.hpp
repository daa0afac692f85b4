/// Acquisition: finds every spot in one image without history and assigns it to a subaperture.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/candidates.hpp"
#include "core/tracking/spot_assignment.hpp"
#include "core/tracking/spot_kinds.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Acquisition for one lattice and one image size. The constructor allocates all memory: call it
/// off the frame path.
class Acquisition {
 public:
  /// Shares its memory for the image with `before`, if there is one and it has as many spots of
  /// this kind in images of this size. Then use both from one thread at a time.
  /// `within`: part of the image, camera pixels, in which candidates are searched; none: all of it.
  /// `kinds`: kinds of the spots, if they differ; null: all are like `spots`.
  Acquisition(SpotModel spots, const std::vector<Vec2>& predicted_px, int image_width,
              int image_height, const Acquisition* before = nullptr,
              std::optional<Disc> within = std::nullopt,
              std::shared_ptr<const SpotKinds> kinds = nullptr);
  // No copies: they would share the memory unnoticed.
  Acquisition(Acquisition&&) = default;
  Acquisition& operator=(Acquisition&&) = default;

  /// Finds candidate spots, near the predicted ones before the rest of the image, verifies each
  /// with `tracker` and assigns the verified spots to subapertures (SpotAssignment). Spots of
  /// several kinds are found and verified kind by kind, by the kinds' own trackers instead, and
  /// assigned by kind and place. Displacements from `predicted_px` may exceed half the pitch,
  /// because the assignment fits them by an affine map (tilt, focus, astigmatism). Missing spots
  /// are searched where their neighbours predict them. Spots that fail are lost.
  ///
  /// Writes one fix per subaperture to `out` and returns the number of spots found. With fewer than
  /// 3 spots, or fewer than half of the subapertures, every fix is lost and the result is 0. An
  /// image of another size also gives 0. RT-safe, but takes milliseconds; with 1,257 spots up to
  /// a quarter of a second.
  int acquire(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
              std::span<SpotFix> out) OVWS_NONBLOCKING;

 private:
  void verify(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch);
  void verify_kind(int kind, const ImageView& image, const SpotTracker& tracker,
                   TrackScratch& scratch);
  SpotFix search_where_expected(int i, const ImageView& image, const SpotTracker& tracker,
                                TrackScratch& scratch) const;
  bool taken(Vec2 at, std::span<const SpotFix> fixes) const;

  SpotModel spots_;
  int image_width_;
  int image_height_;
  std::optional<Disc> within_;
  std::shared_ptr<const SpotKinds> kinds_;
  std::vector<std::shared_ptr<CandidateFinder>> candidates_;  ///< by kind
  SpotAssignment assignment_;
  std::vector<SpotFix> verified_;
  std::vector<Vec2> positions_;  ///< positions of the spots in verified_, camera pixels
  std::vector<int> verified_kinds_;
};

}  // namespace ovws
