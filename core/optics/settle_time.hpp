/// SLM settle time: step response to hologram changes, measured frame by frame.
#pragma once

#include <span>
#include <vector>

#include "core/base/result.hpp"

namespace ovws {

/// Camera frame of a step response: taken around one change of the hologram.
struct StepFrame {
  double begin_ms = 0.0;  ///< start of exposure, since the display accepted the image
  double light = 0.0;     ///< any image quantity that responds to the new hologram
};

/// Settle time of one step: lies between `after_ms` and `until_ms`, because frames are discrete.
struct StepTime {
  double after_ms = 0.0;
  double until_ms = 0.0;
};

/// Settle time of one step. The SLM has settled at the first frame from which all frames stay near
/// their final value, the mean of the last quarter of the frames. Tolerance: four times the noise
/// of this quarter plus 1 % of the change from `before`. Frames must be in order of time; frames
/// with begin_ms < 0 only show that the light stood at `before`. Errors (Errc::refused): fewer than
/// 8 frames, no significant change, not settled within the first half of the frames, or a change
/// before the hologram's.
Result<StepTime> step_time(std::span<const StepFrame> frames, double before);

/// Settle time as robust statistics of several steps. A busy host delays single steps; these are
/// outliers. An outlier's until_ms exceeds the median by more than three standard deviations
/// (estimated from the median absolute deviation) and by more than resolution_ms. Outliers enter
/// only the medians and worst_ms.
struct SettleTime {
  double p50_ms = 0.0;    ///< median of until_ms
  double mad_ms = 0.0;    ///< median absolute deviation of until_ms from p50_ms
  double max_ms = 0.0;    ///< largest until_ms without outliers
  double worst_ms = 0.0;  ///< largest until_ms, outliers included
  int outliers = 0;
  double least_ms = 0.0;       ///< lower bound of max_ms: largest after_ms without outliers
  double resolution_ms = 0.0;  ///< median of until_ms - after_ms
  double margin_ms = 0.0;      ///< a fifth of max_ms, but at least 2 ms
  double proposed_ms = 0.0;    ///< max_ms + margin_ms, whole milliseconds, rounded up
};

/// Computes the settle time from the steps; requires at least one step.
SettleTime settle_time(std::span<const StepTime> steps);

}  // namespace ovws
