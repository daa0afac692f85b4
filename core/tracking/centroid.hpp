/// The centroid family: bright spots only (charge 0).
#pragma once

#include "core/tracking/gaussian_window.hpp"
#include "core/tracking/patch_tracker.hpp"

namespace ovws {

/// The paper's baseline: sum I x / sum I over a fixed disc of 2 lambda/d around the start, pixels
/// as the camera gives them (clipped at zero). Background pulls it towards the start: that is the
/// method, not mended here. Lost if no bright spot is seen inside.
class CentroidTracker final : public PatchTracker {
 public:
  explicit CentroidTracker(const SpotModel& spots);

 protected:
  std::optional<Found> find(const Patch& patch, Vec2 start,
                            TrackScratch& scratch) const OVWS_NONBLOCKING override;

 private:
  GaussianWindow locator_;
};

/// Centroid of what exceeds 0.2 of the local peak above the local background, over a disc of 1.2
/// lambda/d that follows the spot until it rests.
class ThresholdedTracker final : public PatchTracker {
 public:
  explicit ThresholdedTracker(const SpotModel& spots);

 protected:
  std::optional<Found> find(const Patch& patch, Vec2 start,
                            TrackScratch& scratch) const OVWS_NONBLOCKING override;
};

/// Centroid under a Gaussian window of 1/e radius 0.5 lambda/d that follows the spot until it
/// rests: there a flat background cancels.
class WeightedTracker final : public PatchTracker {
 public:
  explicit WeightedTracker(const SpotModel& spots);

  static constexpr double kWindowRadius = 0.5;  ///< 1/e, units of lambda/d

 protected:
  std::optional<Found> find(const Patch& patch, Vec2 start,
                            TrackScratch& scratch) const OVWS_NONBLOCKING override;

 private:
  GaussianWindow window_;
};

}  // namespace ovws
