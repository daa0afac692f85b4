/// How long the SLM's picture takes to stand, from light that was watched frame by frame.
#pragma once

#include <span>
#include <vector>

#include "core/base/result.hpp"

namespace ovws {

/// One frame after a change of the picture.
struct StepFrame {
  double begin_ms = 0.0;  ///< of its exposure, from the moment the display took the picture
  double light = 0.0;     ///< any measure that the change moves
};

/// When the light stood: after `after_ms`, and before `until_ms`.
struct StepTime {
  double after_ms = 0.0;
  double until_ms = 0.0;
};

/// The first frame from which on all stand where the last quarter of them does: within four times
/// that quarter's own noise and a hundredth of the change from `before`. Frames by time; those
/// begun before the change do not count. Errors (Errc::refused): fewer than 8 frames, no change, or
/// a light that does not stand by the last half of the time watched.
Result<StepTime> step_time(std::span<const StepFrame> frames, double before);

/// The SLM is as slow at every change; a busy machine is not. A change whose until_ms is more than
/// three standard deviations (as the median absolute deviation has them), and more than
/// resolution_ms, above the median is an outlier, and counts for the medians and worst_ms only.
struct SettleTime {
  double p50_ms = 0.0;    ///< of until_ms
  double mad_ms = 0.0;    ///< median absolute deviation from p50_ms
  double max_ms = 0.0;    ///< largest until_ms that is no outlier
  double worst_ms = 0.0;  ///< of all
  int outliers = 0;
  double least_ms = 0.0;       ///< the largest after_ms of those: it is no shorter
  double resolution_ms = 0.0;  ///< median of until_ms - after_ms
  double margin_ms = 0.0;      ///< a fifth of max_ms, 2 ms at least
  double proposed_ms = 0.0;    ///< max_ms + margin_ms, whole milliseconds, rounded up
};

/// Requires at least one.
SettleTime settle_time(std::span<const StepTime> steps);

}  // namespace ovws
