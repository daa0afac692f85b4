/// Simulated time: tests skip what they need not wait for.
#pragma once

#include <chrono>
#include <cstdint>

#include "core/port/clock.hpp"

namespace ovws::test {

constexpr std::int64_t kMs = 1'000'000;

/// Lets this time pass at once, for all threads.
inline void skip(std::chrono::nanoseconds time) {
  skipped_ns += time.count();
}

}  // namespace ovws::test
