/// The matched filter for spots with their own template, another tracker for the rest.
#pragma once

#include <memory>
#include <vector>

#include "core/tracking/matched.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Tracks spots that have a template in `own` (null: none) with the matched filter, all others and
/// those of unknown number with `others`. Templates are sampled on the lit pixels.
class MixedTracker final : public SpotTracker {
 public:
  MixedTracker(std::unique_ptr<const SpotTracker> others, const SpotModel& spots,
               std::vector<std::shared_ptr<const TemplateBank>> own);

  int window_half_px() const override;
  TrackScratch make_scratch() const override;
  bool per_spot() const override { return true; }
  SpotFix track(const ImageView& image, Vec2 start_px, TrackScratch& scratch,
                int spot = kAnySpot) const OVWS_NONBLOCKING override;

 private:
  std::unique_ptr<const SpotTracker> others_;
  std::vector<bool> has_own_;
  std::unique_ptr<const SpotTracker> matched_;
};

}  // namespace ovws
