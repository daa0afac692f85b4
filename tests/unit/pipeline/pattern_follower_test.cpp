/// The patterns of frames in time, with lost, dark and mistimed ones: none is ever mistaken.
#include "core/pipeline/pattern_follower.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ovws::test {
namespace {

constexpr double kDark = 1000.0, kBright = 3000.0;  // sums of pixels

/// A camera that is triggered by each slot of a DMD's cycle.
class Cycle {
 public:
  explicit Cycle(int slots, double nominal_error = 0.002)
      : cycle_{slots, std::int64_t(kPeriodNs * (1.0 + nominal_error))} {}

  static constexpr double kPeriodNs = 694'444.4;

  /// The follower's answer for the next slot's frame.
  int next(double light_factor = 1.0, double late_slots = 0.0) {
    const double t_ns = 5e12 + (double(pulse_) + late_slots) * kPeriodNs;
    const bool bright = slot() != 0;
    // The patterns' light differs: strong modes send some of it out of the camera's region.
    const double light = kDark + (bright ? light_factor * (kBright - 40.0 * slot()) - kDark : 0.0);
    ++pulse_;
    return follower_.follow(cycle_, std::int64_t(t_ns), std::max(light, kDark));
  }
  void skip() { ++pulse_; }
  /// The slot that `next` shows.
  int slot() const { return int(pulse_ % cycle_.slots); }
  int until_certain() {
    for (int k = 0; k < 1000; ++k) {
      if (next() > 0) return k;
    }
    return -1;
  }

 private:
  PatternCycle cycle_;
  PatternFollower follower_;
  std::int64_t pulse_ = 7;
};

TEST(PatternFollower, NeverMistakesAPatternInTenThousandFramesWithLostOnes) {
  for (const int slots : {2, 3, 8, 19}) {
    for (const double lost : {0.0, 0.01, 0.05}) {
      Cycle cycle(slots);
      std::mt19937 random{std::uint32_t(slots)};
      std::uniform_real_distribution<double> uniform(0.0, 1.0);
      std::normal_distribution<double> late(0.0, 0.03);
      int certain = 0, frames = 0, mistaken = 0;
      while (frames < 10'000) {
        if (uniform(random) < lost) {
          cycle.skip();
          continue;
        }
        const int slot = cycle.slot(), told = cycle.next(1.0, late(random));
        ++frames;
        certain += told >= 0 ? 1 : 0;
        mistaken += told >= 0 && told != slot ? 1 : 0;
      }
      EXPECT_EQ(mistaken, 0) << slots << " slots, " << lost << " lost";
      EXPECT_GT(certain, frames * (0.95 - 3.0 * lost)) << slots << " slots, " << lost << " lost";
    }
  }
}

TEST(PatternFollower, NeedsTwoMarksWithACompleteCycleBetween) {
  Cycle cycle(8);
  EXPECT_LE(cycle.until_certain(), 17);
  Cycle gappy(8);
  for (int k = 0; k < 400; ++k) {
    if (gappy.slot() == 3) gappy.skip();  // one frame of each cycle is lost
    EXPECT_LT(gappy.next(), 0) << k;
  }
}

TEST(PatternFollower, ACameraThatMissesEverySecondTriggerIsNeverCertain) {
  for (const int slots : {4, 8, 24}) {
    Cycle cycle(slots);
    for (int k = 0; k < 500; ++k) {
      EXPECT_LT(cycle.next(), 0);
      cycle.skip();
    }
  }
}

TEST(PatternFollower, FramesOfACycleWithoutItsMarkAreUncertain) {
  Cycle cycle(6);
  ASSERT_GE(cycle.until_certain(), 0);
  while (cycle.slot() != 0) cycle.next();
  cycle.skip();
  for (int slot = 1; slot < 6; ++slot) EXPECT_LT(cycle.next(), 0);
  EXPECT_EQ(cycle.next(), 0);
  for (int slot = 1; slot < 6; ++slot) EXPECT_EQ(cycle.next(), slot);
}

TEST(PatternFollower, LightWhereItShouldBeDarkAndFramesOutOfTimeEndTheCertainty) {
  Cycle dims(6), mistimed(6);
  ASSERT_GE(dims.until_certain(), 0);
  while (dims.slot() != 3) dims.next();
  EXPECT_LT(dims.next(0.0), 0);  // the light was interrupted
  EXPECT_LT(dims.next(), 0);
  EXPECT_GE(dims.until_certain(), 0);
  ASSERT_GE(mistimed.until_certain(), 0);
  while (mistimed.slot() != 3) mistimed.next();
  EXPECT_LT(mistimed.next(1.0, 0.4), 0);
  EXPECT_LT(mistimed.next(), 0);
}

TEST(PatternFollower, WithoutAMarkNothingIsCertain) {
  Cycle dark(6);
  for (int k = 0; k < 500; ++k) EXPECT_LT(dark.next(0.0), 0);
  EXPECT_GE(dark.until_certain(), 0);
  // A lamp's flicker of a period that is no whole number of slots.
  PatternFollower follower;
  for (int k = 0; k < 2000; ++k) {
    const double light = kBright + 500.0 * std::sin(0.83 * k);
    EXPECT_LT(follower.follow({8, 700'000}, 5'000'000'000'000 + k * 700'000LL, light), 0) << k;
  }
}

TEST(PatternFollower, OfAWrongRefreshRateNothingIsCertain) {
  Cycle cycle(6, 0.2);
  for (int k = 0; k < 500; ++k) EXPECT_LT(cycle.next(), 0);
}

TEST(LightOf, SumsEveryFourthRow) {
  Image<std::uint8_t> image(5, 9, 1);
  image.at(4, 4) = 11;
  image.at(0, 5) = 200;
  EXPECT_EQ(light_of(view_of(image)), 25.0);
}

}  // namespace
}  // namespace ovws::test
