#include "core/pipeline/arrival_clock.hpp"

#include <algorithm>

namespace ovws {

std::int64_t ArrivalClock::undelayed_mono_ns(std::int64_t arrival_mono_ns,
                                             std::int64_t device_ns) OVWS_NONBLOCKING {
  if (device_ns == 0) return arrival_mono_ns;
  if (device_ns < last_device_ns_) reset();
  last_device_ns_ = device_ns;
  if (arrival_mono_ns >= span_end_ns_) {
    min_previous_ns_ = min_now_ns_;
    min_now_ns_ = kNone;
    span_end_ns_ = arrival_mono_ns + kSpanNs;
  }
  min_now_ns_ = std::min(min_now_ns_, arrival_mono_ns - device_ns);
  return device_ns + std::min(min_now_ns_, min_previous_ns_);
}

}  // namespace ovws
