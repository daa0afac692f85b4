/// Minimum-delay estimate of frame arrival times: separates late delivery from a late exposure.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/base/realtime.hpp"

namespace ovws {

/// Estimates a frame's arrival time without queueing delay. Queues (network, driver, a busy host)
/// delay the arrival; the camera's own timestamp is not delayed. The minimum of "arrival - device
/// timestamp" over the last seconds belongs to a frame without queueing. Device timestamp + this
/// minimum is the undelayed arrival time. One thread at a time. RT-safe.
class ArrivalClock {
 public:
  /// The time at which the frame would have arrived without a queue, CLOCK_MONOTONIC ns; exposure
  /// times count back from it. It is never later than `arrival_mono_ns`, and equal if the camera
  /// sends no timestamps (`device_ns` is 0). The error is at most the drift between the clocks of
  /// host and camera in 15 s, the longest time for which a minimum is used. Frames more than 10 s
  /// apart count as they came, with their delay. If the camera's clock is set back, the minimum is
  /// sought again.
  std::int64_t undelayed_mono_ns(std::int64_t arrival_mono_ns,
                                 std::int64_t device_ns) OVWS_NONBLOCKING {
    if (device_ns == 0) return arrival_mono_ns;
    if (device_ns < last_device_ns_) reset();
    last_device_ns_ = device_ns;
    if (arrival_mono_ns >= span_end_ns_) {
      const bool gap = arrival_mono_ns >= span_end_ns_ + kSpanNs;
      min_previous_ns_ = gap ? kNone : min_now_ns_;
      min_now_ns_ = kNone;
      span_end_ns_ = arrival_mono_ns + kSpanNs;
    }
    min_now_ns_ = std::min(min_now_ns_, arrival_mono_ns - device_ns);
    return device_ns + std::min(min_now_ns_, min_previous_ns_);
  }
  /// Restarts the estimate. Call it when the camera stream or the exposure time changes.
  void reset() OVWS_NONBLOCKING { *this = ArrivalClock{}; }

 private:
  static constexpr std::int64_t kSpanNs =
      5'000'000'000;  ///< the minimum covers the last one to two spans of this length
  static constexpr std::int64_t kNone = INT64_MAX;

  std::int64_t span_end_ns_ = 0;
  std::int64_t last_device_ns_ = 0;
  std::int64_t min_now_ns_ = kNone;
  std::int64_t min_previous_ns_ = kNone;
};

}  // namespace ovws
