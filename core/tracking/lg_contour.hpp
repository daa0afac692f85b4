/// The paper's LG method (supplement S1) by contours: the oracle of the fast one.
#pragma once

#include <complex>

#include "core/tracking/patch_tracker.hpp"

namespace ovws {

/// Psi = I * K_LG, K_LG = i pi^2 sigma^4 (x + iy) exp(-pi^2 sigma^2 (x^2 + y^2)), sigma = 1/(pi w),
/// on every pixel within lambda/d of the start; zero contours of Re Psi and of Im Psi by marching
/// squares; their crossings, each then found again on a grid of 1/16 pixel; of the plausible ones
/// the one with the lowest recorded intensity (charge 0: the highest). Plausible: within lambda/d
/// of the start, of index +1 (no saddle of the smoothed image), and passed by SpotCheck. Allocates,
/// and takes milliseconds a spot.
class LgContourTracker final : public PatchTracker {
 public:
  LgContourTracker(const SpotModel& spots, double kernel_radius_px);

 protected:
  std::optional<Found> find(const Patch& patch, Vec2 start, TrackScratch& scratch) const override;

 private:
  std::complex<double> psi(const Patch& patch, Vec2 at) const;

  double w_;
  int half_;
};

}  // namespace ovws
