/// LG method of the paper (supplement S1) by zero contours: the test oracle of LgTracker.
#pragma once

#include <complex>

#include "core/tracking/patch_tracker.hpp"

namespace ovws {

/// LG contour method: evaluates Psi = I * K_LG on every pixel within lambda/d of the start, with
/// sigma = 1/(pi w) and K_LG = i pi^2 sigma^4 (x + iy) exp(-pi^2 sigma^2 (x^2 + y^2)). Marching
/// squares give the zero contours of Re Psi and of Im Psi, and each crossing is refined on a grid
/// of 1/16 pixel. A crossing is valid if it is within lambda/d of the start, has the index +1 (no
/// saddle of the smoothed image) and passes SpotCheck. The valid crossing with the lowest recorded
/// intensity wins (charge 0: the highest). Allocates and takes milliseconds per spot: not for the
/// frame path.
class LgContourTracker final : public PatchTracker {
 public:
  LgContourTracker(const SpotModel& spots, double kernel_radius_px);

 protected:
  std::optional<Found> find(Patch& patch, Vec2 start, TrackScratch& scratch) const override;

 private:
  std::complex<double> psi(const Patch& patch, Vec2 at) const;

  double w_;
  int half_;
};

}  // namespace ovws
