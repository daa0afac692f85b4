/// The fast LG tracker: Newton's method on the paper's Psi, over a small window.
#pragma once

#include "core/tracking/gaussian_window.hpp"
#include "core/tracking/patch_tracker.hpp"

namespace ovws {

/// Psi = I * K_LG is, up to a constant, the gradient of the image smoothed by a Gaussian of 1/e
/// radius w. Charge not 0: finds the minimum of the smoothed image near the start, the dark core.
/// Charge 0: finds the maximum. Either has index +1; a saddle, a zero that is almost one (its
/// smaller curvature below an eighth of an unaberrated spot's), that fails SpotCheck, or that is
/// further than lambda/d from the start is lost. Starts within 0.5 lambda/d converge.
///
/// Limits, charge +-1, kernel 0.4, measured on the default bench: 0.2 wave RMS of any mode up to
/// j = 14 costs at most one spot of 19 (spherical aberration), 0.8 wave of focus or astigmatism
/// none; inside one subaperture, astigmatism up to 0.16 wave of amplitude is followed.
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
