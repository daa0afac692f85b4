/// Monotonic clock for intervals, UTC for timestamps. Never subtract one from the other.
#pragma once

#include <cstdint>
#include <ctime>

namespace ovws {

/// ns of CLOCK_MONOTONIC: for every interval and deadline. RT-safe.
inline std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

/// ns since the UNIX epoch, UTC: for timestamps in messages and files. RT-safe.
inline std::int64_t utc_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace ovws
