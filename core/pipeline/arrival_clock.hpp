/// When a frame would have arrived had nothing held it up: so that late delivery is not taken for a
/// late exposure.
#pragma once

#include <cstdint>

#include "core/base/realtime.hpp"

namespace ovws {

/// A frame may wait in queues (network, driver, a busy host) for any time between its exposure and
/// its arrival here. The camera's own stamps do not: the smallest difference "arrival - device
/// stamp" of the last seconds is that of a frame that did not wait, and device stamp + that
/// difference is when this one would have arrived. One thread at a time. RT-safe.
class ArrivalClock {
 public:
  /// The time from which exposure times are to be counted back, CLOCK_MONOTONIC ns: never later
  /// than `arrival_mono_ns`, and that itself if the camera gives no stamps. The clocks may drift by
  /// what they like in 10 s without harm above that drift; a device clock that is set back starts
  /// anew.
  std::int64_t unhindered_mono_ns(std::int64_t arrival_mono_ns,
                                  std::int64_t device_ns) OVWS_NONBLOCKING;
  /// Another stream, or another exposure time: what was learnt no longer holds.
  void forget() OVWS_NONBLOCKING { *this = ArrivalClock{}; }

 private:
  static constexpr std::int64_t kSpanNs =
      5'000'000'000;  ///< the minimum is over one to two of these
  static constexpr std::int64_t kNone = INT64_MAX;

  std::int64_t span_end_ns_ = 0;
  std::int64_t last_device_ns_ = 0;
  std::int64_t smallest_now_ns_ = kNone;
  std::int64_t smallest_before_ns_ = kNone;
};

}  // namespace ovws
