/// Whether the bench still stands where it stood when a gain sweep took its references: pure
/// computation.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "daemon/ovwsd/frames/frame_series.hpp"

namespace ovws {

/// From one mean of positions to another, camera pixels. All that moves counts, the tilt that all
/// spots share included.
struct SpotMotion {
  int lost = 0;             ///< spots found in fewer than half of the frames; the rest is of others
  Vec2 mean_px;             ///< over the spots
  double largest_px = 0.0;  ///< of one spot, any direction
  int largest_at = 0;       ///< that subaperture
  /// Of one spot's motion along one axis, the largest: by how the spots scatter in `frames`, which
  /// is taken for the scatter of before.
  double standard_error_px = 0.0;
};

/// From `before_px`, the mean of `frames_before` frames, to the mean of `frames`. NaN in
/// `before_px`: no such spot.
SpotMotion spot_motion(const std::vector<Vec2>& before_px, int frames_before,
                       const std::vector<SeriesFrame>& frames);

/// The most that a spot may have moved, of lambda/d: 1/20.
constexpr double kMostMotion = 0.05;

/// Errc::refused if a spot is lost or has moved by more than `limit_px` (field "anew"), or if four
/// standard errors are more than that and nothing can be told (field "reference_frames").
/// `arm`: its name, for the reason.
Result<void> check_unmoved(const SpotMotion& motion, double limit_px, const std::string& arm);

}  // namespace ovws
