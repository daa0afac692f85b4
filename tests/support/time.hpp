/// Units of the nanoseconds that clocks count.
#pragma once

#include <cstdint>

namespace ovws::test {

constexpr std::int64_t kMs = 1'000'000;

}  // namespace ovws::test
