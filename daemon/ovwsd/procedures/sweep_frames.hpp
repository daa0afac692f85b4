/// Evaluates the frames of a gain sweep: the results of one cell, and the motion of the bench since
/// the references were taken. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/zernike.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovwsd/frames/frame_series.hpp"
#include "proto/tables/experiment.hpp"

namespace ovws {

/// Mean position of each spot; NaN if the spot is found in fewer than half of the frames, or only
/// once.
std::vector<Vec2> mean_positions(const std::vector<SeriesFrame>& frames);
/// Median level and noise of the found spots, and the brightest pixel.
SpotLevels levels_of(const std::vector<SeriesFrame>& frames);
/// Reconstructs each frame's modes and their residual variance against `introduced`.
std::vector<CellMeasured::Frame> judge_frames(const std::vector<SeriesFrame>& frames,
                                              const Reconstructor& reconstructor,
                                              const std::vector<Mode>& introduced);

/// Motion between two mean positions of the spots, camera pixels. Includes the motion common to all
/// spots (tilt).
struct SpotMotion {
  int lost = 0;  ///< spots found in fewer than half of the frames; other fields ignore lost spots
  Vec2 mean_px;  ///< mean over the spots
  double largest_px = 0.0;  ///< largest distance that a single spot moved
  int largest_at = 0;       ///< subaperture of that spot
  /// Largest standard error of a spot's motion along one axis, from the scatter in `frames`. The
  /// frames of the earlier mean are assumed to scatter equally.
  double standard_error_px = 0.0;
};

/// Motion from `before_px`, the mean of `frames_before` frames, to the mean of `frames`. Spots with
/// NaN in `before_px` are ignored.
SpotMotion spot_motion(const std::vector<Vec2>& before_px, int frames_before,
                       const std::vector<SeriesFrame>& frames);

/// Checks that the spots have not moved. Errc::refused, field "anew": a spot is lost, or has moved
/// by more than `limit_px`. Errc::refused, field "reference_frames": four standard errors exceed
/// the limit, so motion cannot be excluded. `arm`: the arm's name, for the message.
Result<void> check_unmoved(const SpotMotion& motion, double limit_px, const std::string& arm);

}  // namespace ovws
