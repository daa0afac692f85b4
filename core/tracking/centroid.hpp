/// Centroid trackers (centre of gravity) for bright spots, charge 0.
#pragma once

#include "core/tracking/gaussian_window.hpp"
#include "core/tracking/patch_tracker.hpp"

namespace ovws {

/// Plain centre of gravity, the paper's baseline: sum I x / sum I of the recorded pixels (clipped
/// at zero), over a fixed disc of radius 2 lambda/d around the start. Background biases the result
/// towards the start; the method does not correct this. The spot is lost if no bright spot is
/// within lambda/d of the start.
class CentroidTracker final : public PatchTracker {
 public:
  explicit CentroidTracker(const SpotModel& spots);

 protected:
  std::optional<Found> find(Patch& patch, Vec2 start,
                            TrackScratch& scratch) const OVWS_NONBLOCKING override;

 private:
  GaussianWindow locator_;
};

/// Thresholded centre of gravity, over a disc of radius 1.2 lambda/d that follows the spot until it
/// converges. The threshold is the local background plus 0.2 of the local peak above it.
class ThresholdedTracker final : public PatchTracker {
 public:
  explicit ThresholdedTracker(const SpotModel& spots);

 protected:
  std::optional<Found> find(Patch& patch, Vec2 start,
                            TrackScratch& scratch) const OVWS_NONBLOCKING override;
};

/// Weighted centre of gravity: centroid under a Gaussian window of 1/e radius 0.5 lambda/d that
/// follows the spot until the iteration converges. At convergence a flat background cancels.
class WeightedTracker final : public PatchTracker {
 public:
  explicit WeightedTracker(const SpotModel& spots);

  static constexpr double kWindowRadius = 0.5;  ///< 1/e radius, units of lambda/d

 protected:
  std::optional<Found> find(Patch& patch, Vec2 start,
                            TrackScratch& scratch) const OVWS_NONBLOCKING override;

 private:
  GaussianWindow window_;
};

}  // namespace ovws
