/// Limits the share of a thread's time that requests of less urgency take.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/port/clock.hpp"

namespace ovws {

/// Gives work a tenth of the thread's time. For one thread.
class TimeShare {
 public:
  /// Whether the work may be done now.
  bool is_due() const { return monotonic_ns() >= next_ns_; }
  /// Does the work. It is due again after nine times as long, half a second at most.
  template <class Work>
  void run(const Work& work) {
    const std::int64_t begin_ns = monotonic_ns();
    work();
    const std::int64_t end_ns = monotonic_ns();
    next_ns_ = end_ns + std::min(kPause * (end_ns - begin_ns), kMaxPauseNs);
  }

 private:
  static constexpr std::int64_t kPause = 9;  ///< pause in multiples of the work's duration
  static constexpr std::int64_t kMaxPauseNs = 500'000'000;
  std::int64_t next_ns_ = 0;
};

}  // namespace ovws
