#include "core/pipeline/arrival_clock.hpp"

#include <gtest/gtest.h>

#include "core/pipeline/frame_rules.hpp"
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

/// The camera's clock is 50 ppm slow and a frame comes every 1,000 s: a minimum of the frame before
/// is 50 ms too low.
TEST(ArrivalClock, ADriftOfMinutesDoesNotCountForRareFrames) {
  ArrivalClock clock;
  for (std::int64_t k = 1; k < 10; ++k) {
    const std::int64_t exposed = k * 1'000'000 * kMs, arrival = exposed + kTransfer;
    const std::int64_t device = kDeviceZero + exposed - exposed / 20'000;
    EXPECT_EQ(clock.undelayed_mono_ns(arrival, device), arrival) << k;
  }
}

/// A hologram settles 15 ms before such a frame's exposure of 20 ms.
TEST(ArrivalClock, ARareFrameIsNotOfTheHologramBefore) {
  constexpr std::uint64_t kEpoch = 7;
  constexpr std::int64_t kExposure = 20 * kMs;
  ArrivalClock clock;
  clock.undelayed_mono_ns(kTransfer, kDeviceZero);
  const std::int64_t end = 1'000'000 * kMs, begin = end - kExposure;
  ShownHologram shown;
  shown.healthy = true;
  shown.previous = {4, kEpoch, 1 * kMs, 2 * kMs};
  shown.current = {5, kEpoch, begin - 20 * kMs, begin - 15 * kMs};
  const std::int64_t undelayed =
      clock.undelayed_mono_ns(end + kTransfer, kDeviceZero + end - end / 20'000);
  const HologramVerdict verdict =
      judge_hologram(shown, kEpoch, undelayed - kExposure - kTransfer, undelayed);
  EXPECT_EQ(verdict.hologram_id, 5U);
  EXPECT_TRUE(verdict.settled);
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
