/// The position of one spot from all its pixels, without a rendering of the whole sensor.
#pragma once

#include <memory>

#include "core/spots/rendered_spot.hpp"
#include "core/tracking/spot_shape.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Fit of one spot's position to all its pixels, as `fit` with two estimates. Renders the ideal
/// spot at the current position and repeats until the position converges. Uses saturated pixels,
/// too. Starts from the fix of `lg`, or from `start_px` if `lg` loses the spot. The RMS error of a
/// spot of ideal shape is within a few percent of the Cramer-Rao bound. A spot is lost if the fit
/// does not converge, if its level is not significant, if its shape is unlike a spot, or if it is
/// farther than lambda/d from the start or at the image's edge. `quality` is the ideal spot's share
/// of the intensity. Takes some 0.3 ms, off the frame path: it allocates.
class PositionFit final : public SpotTracker {
 public:
  /// `lg`: a tracker for `spots`, which gives the first position.
  PositionFit(const SpotModel& spots, std::unique_ptr<const SpotTracker> lg);

  TrackScratch make_scratch() const override { return lg_->make_scratch(); }
  SpotFix track(const ImageView& image, Vec2 start_px,
                TrackScratch& scratch) const OVWS_NONBLOCKING override;

 private:
  RenderedSpot rendered(Vec2 at_px, const SpotWindow& window) const;

  SpotModel spots_;
  ModelShape shape_;
  SpotWindow window_;  ///< size of the fit window
  std::unique_ptr<const SpotTracker> lg_;
};

/// For spots on the lit pixels of a camera, see plane_tracker.hpp. Errors: those of make_tracker.
Result<std::unique_ptr<const SpotTracker>> make_position_fit(const SpotModel& spots);

}  // namespace ovws
