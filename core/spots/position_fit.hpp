/// The position of one spot from all its pixels, without a rendering of the whole sensor.
#pragma once

#include <memory>

#include "core/spots/rendered_spot.hpp"
#include "core/tracking/spot_shape.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// The fit of one spot's position, as `fit` with two estimates: renders the ideal spot at the
/// present position and repeats until the position converges. Saturated pixels count, too. Starts
/// where `lg` finds it, or at the start if it does not. The RMS error of a spot of ideal shape is
/// within a few percent of the Cramer-Rao bound. Lost: a fit that does not converge or whose level
/// is not significant, a position farther than lambda/d from the start or at the image's edge, and
/// a spot that looks like none. `quality` is the ideal spot's share of the intensity. Some 0.3 ms,
/// off the frame path: it allocates.
class PositionFit final : public SpotTracker {
 public:
  /// `lg`: a tracker of the same spots.
  PositionFit(const SpotModel& spots, std::unique_ptr<const SpotTracker> lg);

  int window_half_px() const override { return lg_->window_half_px(); }
  TrackScratch make_scratch() const override { return lg_->make_scratch(); }
  SpotFix track(const ImageView& image, Vec2 start_px,
                TrackScratch& scratch) const OVWS_NONBLOCKING override;

 private:
  RenderedSpot rendered(Vec2 at_px, const SpotWindow& window) const;

  SpotModel spots_;
  ModelShape shape_;
  SpotWindow window_;  ///< its size
  std::unique_ptr<const SpotTracker> lg_;
};

/// For spots on the lit pixels of a camera, see plane_tracker.hpp. Errors: those of make_tracker.
Result<std::unique_ptr<const SpotTracker>> make_position_fit(const SpotModel& spots);

}  // namespace ovws
