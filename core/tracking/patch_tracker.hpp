/// What all trackers share: load the patch, find, check, and refuse what is too near an edge.
#pragma once

#include <optional>

#include "core/tracking/matched.hpp"
#include "core/tracking/patch.hpp"
#include "core/tracking/spot_check.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

class PatchTracker : public SpotTracker {
 public:
  int window_half_px() const final { return half_; }
  TrackScratch make_scratch() const final;
  SpotFix track(const ImageView& image, Vec2 start_px, TrackScratch& scratch,
                int spot = kAnySpot) const OVWS_NONBLOCKING final;

 protected:
  struct Found {
    Vec2 at;
    SpotCheck::Verdict verdict;
  };

  /// How far from the start a spot may be, in units of lambda/d: further, it is lost.
  static constexpr double kCapture = 1.0;

  /// `kernel_half_px`: half-width of the square that `find` reads around a position.
  PatchTracker(const SpotModel& spots, int kernel_half_px, int sum_floats);

  /// The spot nearest in the sense of the tracker, checked; or one that the check is unsure of,
  /// which is then asked of the matched filter. The patch reaches capture_px() plus kernel_half_px
  /// and check's reach around the start.
  virtual std::optional<Found> find(const Patch& patch, Vec2 start,
                                    TrackScratch& scratch) const OVWS_NONBLOCKING = 0;

  const SpotModel& spots() const { return spots_; }
  const SpotGeometry& geometry() const { return geometry_; }
  const SpotCheck& check() const { return check_; }
  double capture_px() const { return kCapture * spots_.lambda_d_px; }

 private:
  bool confirm(const ImageView& image, Found& found, TrackScratch& scratch) const;

  SpotModel spots_;
  SpotGeometry geometry_;
  int kernel_half_;
  int half_;
  int sum_floats_;
  SpotCheck check_;
  MatchedTracker second_;  ///< in noise it sees the whole spot where the check sees parts
};

}  // namespace ovws
