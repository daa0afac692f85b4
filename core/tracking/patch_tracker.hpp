/// Base class of the patch trackers (centroid family, LG): loads a patch, finds the spot, checks
/// it, and rejects spots too near the image's edge.
#pragma once

#include <optional>

#include "core/tracking/patch.hpp"
#include "core/tracking/spot_check.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

class PatchTracker : public SpotTracker {
 public:
  TrackScratch make_scratch() const final;
  SpotFix track(const ImageView& image, Vec2 start_px,
                TrackScratch& scratch) const OVWS_NONBLOCKING final;

 protected:
  struct Found {
    Vec2 at;
    SpotCheck::Verdict verdict;
  };

  /// Capture range, units of lambda/d: a spot farther from the start is lost.
  static constexpr double kCapture = 1.0;

  /// `kernel_half_px`: half-width of the square that `find` reads around a position. `sum_floats`:
  /// floats of TrackScratch::sums that `find` needs. `spare`: how far from the patch's middle
  /// `find` reads that square, units of lambda/d, at most kCapture; but at least 4 px.
  PatchTracker(const SpotModel& spots, int kernel_half_px, int sum_floats, double spare = kCapture);

  /// Finds the spot near `start` and validates it with SpotCheck. Around the start the patch
  /// extends at least spare_px() plus the larger of kernel_half_px and SpotCheck::reach_px. With a
  /// spare below kCapture the patch must follow the position (Patch::follow).
  virtual std::optional<Found> find(Patch& patch, Vec2 start,
                                    TrackScratch& scratch) const OVWS_NONBLOCKING = 0;

  const SpotModel& spots() const { return spots_; }
  const SpotGeometry& geometry() const { return geometry_; }
  const SpotCheck& check() const { return check_; }
  double capture_px() const { return kCapture * spots_.lambda_d_px; }
  int spare_px() const { return spare_; }

 private:
  SpotModel spots_;
  SpotGeometry geometry_;
  int kernel_half_;
  int spare_;
  int half_;
  int sum_floats_;
  SpotCheck check_;
};

}  // namespace ovws
