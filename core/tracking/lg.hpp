/// Fast LG tracker: Newton iteration on the paper's Psi, over a small window.
#pragma once

#include "core/tracking/gaussian_window.hpp"
#include "core/tracking/patch_tracker.hpp"

namespace ovws {

/// Psi = I * K_LG is, up to a constant, the gradient of the image smoothed by a Gaussian of 1/e
/// radius w. A saddle-free Newton iteration from the start finds a zero of it: for a vortex the
/// minimum of the smoothed image (the dark core), for charge 0 its maximum. Both have index +1.
///
/// Lost: a saddle; a near-saddle, whose smaller curvature is below an eighth of an unaberrated
/// spot's; a zero that fails SpotCheck or is farther than lambda/d from the start. Starts within
/// 0.5 lambda/d converge.
///
/// Limits, measured on the default bench with charge +-1 and kernel 0.4: 0.2 wave RMS of any mode
/// up to j = 14 loses at most one spot of 19 (spherical aberration); 0.8 wave of focus or
/// astigmatism loses none. Within one subaperture, astigmatism of up to 0.16 wave amplitude is
/// tracked.
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
