/// Fast LG tracker: Newton iteration on the paper's Psi, over a small window.
#pragma once

#include "core/tracking/gaussian_window.hpp"
#include "core/tracking/patch_tracker.hpp"

namespace ovws {

/// LG tracker: a saddle-free Newton iteration from the start finds a zero of Psi = I * K_LG. Up to
/// a constant, Psi is the gradient of the image smoothed by a Gaussian of 1/e radius w. The zero is
/// the minimum of the smoothed image for a vortex (the dark core), and its maximum for charge 0.
/// Minima and maxima have the index +1.
///
/// A spot is lost if the zero is a saddle or nearly a saddle (smaller curvature below an eighth of
/// an unaberrated spot's), fails SpotCheck, or is farther than lambda/d from the start. Starts
/// within 0.5 lambda/d of the spot converge.
///
/// Limits, measured on the default bench with charge +-1 and kernel 0.4: 0.2 wave RMS of any mode
/// up to j = 14 loses at most one spot of 19 (spherical aberration); 0.8 wave of focus or
/// astigmatism loses none. Within one subaperture, astigmatism of up to 0.16 wave amplitude is
/// tracked.
class LgTracker final : public PatchTracker {
 public:
  LgTracker(const SpotModel& spots, double kernel_radius_px);

 protected:
  std::optional<Found> find(Patch& patch, Vec2 start,
                            TrackScratch& scratch) const OVWS_NONBLOCKING override;

 private:
  GaussianWindow window_;
};

}  // namespace ovws
