#include "core/pipeline/arrival_clock.hpp"

#include <gtest/gtest.h>

#include "tests/support/time.hpp"

namespace ovws {
namespace {

using test::kMs;

constexpr std::int64_t kDeviceZero = 7'000'000 * kMs;  // the two clocks have nothing in common
constexpr std::int64_t kTransfer = 2 * kMs;

/// The k-th frame of a 100 Hz camera, held up by so much.
std::int64_t undelayed(ArrivalClock& clock, int k, std::int64_t held_up_ns) {
  const std::int64_t exposed = k * 10 * kMs;
  return clock.undelayed_mono_ns(exposed + kTransfer + held_up_ns, kDeviceZero + exposed);
}

TEST(ArrivalClock, AFrameThatWasHeldUpCountsAsArrivedWhenItShouldHave) {
  ArrivalClock clock;
  for (int k = 1; k < 10; ++k) undelayed(clock, k, 0);
  EXPECT_EQ(undelayed(clock, 10, 300 * kMs), 100 * kMs + kTransfer);
}

TEST(ArrivalClock, NothingIsLaterThanItsRealArrival) {
  ArrivalClock clock;
  for (int k = 1; k < 2000; ++k) {
    const std::int64_t held_up = (k * 7919) % (40 * kMs);
    EXPECT_LE(undelayed(clock, k, held_up), k * 10 * kMs + kTransfer + held_up);
  }
}

TEST(ArrivalClock, WithoutStampsTheArrivalIsAllThatIsKnown) {
  ArrivalClock clock;
  EXPECT_EQ(clock.undelayed_mono_ns(123 * kMs, 0), 123 * kMs);
}

TEST(ArrivalClock, ADriftOf100PpmIsForgottenWithinTenSeconds) {
  ArrivalClock clock;
  for (int k = 1; k < 6000; ++k) {  // one minute, the camera's clock too fast
    const std::int64_t exposed = k * 10 * kMs;
    const std::int64_t arrival = exposed + kTransfer;
    const std::int64_t device = kDeviceZero + exposed + exposed / 10'000;
    EXPECT_NEAR(double(clock.undelayed_mono_ns(arrival, device)), double(arrival), double(kMs));
  }
}

TEST(ArrivalClock, ADeviceClockThatIsSetBackStartsAnew) {
  ArrivalClock clock;
  for (int k = 1; k < 10; ++k) undelayed(clock, k, 0);
  EXPECT_EQ(clock.undelayed_mono_ns(200 * kMs, 5 * kMs), 200 * kMs);
}

TEST(ArrivalClock, AfterForgettingTheFirstFrameIsTakenAsItCame) {
  ArrivalClock clock;
  undelayed(clock, 1, 0);
  clock.reset();
  EXPECT_EQ(undelayed(clock, 2, 50 * kMs), 20 * kMs + kTransfer + 50 * kMs);
}

}  // namespace
}  // namespace ovws
