/// SLM settle time: step response to hologram changes, measured frame by frame.
#pragma once

#include <span>
#include <vector>

#include "core/base/result.hpp"

namespace ovws {

/// One frame around a change of the hologram.
struct StepFrame {
  double begin_ms = 0.0;  ///< start of exposure, from when the display accepted the image
  double light = 0.0;     ///< any quantity that responds to the change
};

/// Bounds on one settle time: it is between `after_ms` and `until_ms`.
struct StepTime {
  double after_ms = 0.0;
  double until_ms = 0.0;
};

/// Settle time of one step: ends with the first frame from which all stay within a tolerance of the
/// mean of the last quarter. The tolerance is four times that quarter's noise plus 1 % of the
/// change from `before`. Frames in order of time; those with begin_ms < 0 are ignored. Errors
/// (Errc::refused): fewer than 8 frames, no significant change, or not settled within the first
/// half of the frames.
Result<StepTime> step_time(std::span<const StepFrame> frames, double before);

/// Robust statistics of several steps. Delays by a busy host show as outliers: an until_ms that
/// exceeds the median by more than three standard deviations (estimated from the median absolute
/// deviation) and by more than resolution_ms. Outliers count for the medians and worst_ms only.
struct SettleTime {
  double p50_ms = 0.0;    ///< median of until_ms
  double mad_ms = 0.0;    ///< median absolute deviation from p50_ms
  double max_ms = 0.0;    ///< largest until_ms without outliers
  double worst_ms = 0.0;  ///< largest until_ms of all
  int outliers = 0;
  double least_ms = 0.0;       ///< lower bound: largest after_ms without outliers
  double resolution_ms = 0.0;  ///< median of until_ms - after_ms
  double margin_ms = 0.0;      ///< a fifth of max_ms, but at least 2 ms
  double proposed_ms = 0.0;    ///< max_ms + margin_ms, whole milliseconds, rounded up
};

/// Requires at least one step.
SettleTime settle_time(std::span<const StepTime> steps);

}  // namespace ovws
