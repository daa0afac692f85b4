/// Where the time of the loop's steps goes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/control/mode_law.hpp"

namespace ovws {

/// Where the time of one step goes: from presenting a hologram to presenting the next,
/// milliseconds.
struct StepTimes {
  double settle_ms = 0.0;  ///< until the liquid crystal has settled
  double wait_ms = 0.0;  ///< until the last usable frame begins; if it is older, until it is known
  double exposure_ms = 0.0;  ///< of that frame; 0 if it is older
  double compute_ms = 0.0;   ///< its transfer and measurement; 0 if it is older
  double render_ms = 0.0;    ///< of the new correction and its hologram
  double refresh_ms = 0.0;  ///< wait for the display's next refresh, most of it before the decision
  double present_ms = 0.0;  ///< until the display has accepted the hologram

  double total_ms() const {
    return settle_ms + wait_ms + exposure_ms + compute_ms + render_ms + refresh_ms + present_ms;
  }
};

/// One step of the loop.
struct LoopStep {
  StepTimes times;
  double delay_ms = 0.0;    ///< delay of its correction, see LoopTiming::delay_s
  bool has_newest = false;  ///< it used a frame of the newest hologram, not only earlier ones
};

struct StepSummary {
  int steps = 0;  ///< steps that are summarised; 0: all other values are 0
  double p50_ms = 0.0, p99_ms = 0.0;
  double delay_ms = 0.0;      ///< mean delay of the corrections
  double newest_share = 0.0;  ///< share of the steps with a frame of the newest hologram
  StepTimes mean;

  LoopTiming timing() const { return {1e-3 * mean.total_ms(), 1e-3 * delay_ms}; }
};

/// The last steps of a loop. Not thread-safe.
class StepLog {
 public:
  static constexpr std::size_t kSteps = 1024;

  void add(const LoopStep& step);
  StepSummary summary() const;

 private:
  std::array<LoopStep, kSteps> steps_{};
  std::size_t count_ = 0;
};

/// A duration in the last kSteps steps. Not thread-safe.
class RecentTime {
 public:
  static constexpr std::size_t kSteps = 32;

  void add(std::int64_t took_ns) { last_ns_[count_++ % kSteps] = took_ns; }
  /// The time that `share` of the steps did not exceed, 0 to 1; 0.5 gives the median. 0: no step is
  /// known.
  std::int64_t ns(double share) const;

 private:
  std::array<std::int64_t, kSteps> last_ns_{};
  std::size_t count_ = 0;
};

}  // namespace ovws
