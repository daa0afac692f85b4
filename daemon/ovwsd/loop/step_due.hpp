/// When a closed loop takes its next step.
#pragma once

#include <cstdint>

namespace ovws {

/// What decides when the step is due that uses the last observed frame. Times are CLOCK_MONOTONIC.
struct StepState {
  static constexpr std::int64_t kNever = INT64_MAX;

  std::int64_t t_observed_ns = 0;      ///< when the frame was observed
  bool has_newest = false;             ///< the frame shows the newest hologram
  std::int64_t t_exposed_ns = kNever;  ///< when a frame of that hologram has been exposed for sure
  /// A refresh of the display, and the time from one to the next; 0: not known.
  std::int64_t t_refresh_ns = 0, refresh_ns = 0;
  /// From a step to the moment at which its hologram is ready: in the median, and for nearly all.
  std::int64_t usual_prepare_ns = 0, safe_prepare_ns = 0;
};

/// When to step. If refreshes are known: so late that the hologram is just ready for one. That is
/// the first refresh before which a frame of the newest hologram has been exposed, and which can
/// still be reached. If they are not known: at once with a frame of the newest hologram, or when
/// one has been exposed.
std::int64_t t_due_ns(const StepState& state);

}  // namespace ovws
