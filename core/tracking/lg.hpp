/// The fast LG tracker: Newton's method on the paper's Psi, over a small window.
#pragma once

#include "core/tracking/gaussian_window.hpp"
#include "core/tracking/patch_tracker.hpp"

namespace ovws {

/// Psi = I * K_LG is, up to a constant, the gradient of the image smoothed by a Gaussian of 1/e
/// radius w. Charge not 0: finds the minimum of the smoothed image near the start, the dark core.
/// Charge 0: finds the maximum. Either has index +1; a saddle, a zero that fails SpotCheck, or one
/// further than lambda/d from the start is lost. Starts within 0.5 lambda/d converge.
class LgTracker final : public PatchTracker {
 public:
  LgTracker(const SpotModel& spots, double kernel_radius_px);

 protected:
  std::optional<Found> find(const Patch& patch, Vec2 start,
                            TrackScratch& scratch) const OVWS_NONBLOCKING override;

 private:
  GaussianWindow window_;
};

}  // namespace ovws
