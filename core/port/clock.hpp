/// Clocks: monotonic time for intervals, UTC for timestamps. Never subtract one from the other.
#pragma once

#include <atomic>
#include <cstdint>
#include <ctime>

namespace ovws {

/// Time that tests have skipped: 0 in every program. With it patience, back-off and watchdogs end
/// without waiting.
inline std::atomic<std::int64_t> skipped_ns{0};

/// Monotonic time (CLOCK_MONOTONIC) in ns, for intervals and deadlines. RT-safe.
inline std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec +
         skipped_ns.load(std::memory_order_relaxed);
}

/// UTC in ns since the UNIX epoch, for timestamps in messages and files. RT-safe.
inline std::int64_t utc_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace ovws
