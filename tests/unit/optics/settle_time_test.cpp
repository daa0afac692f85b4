/// Settle times recovered from noisy intensities, for any phase of the camera's frames.
#include "core/optics/settle_time.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ovws {
namespace {

/// The light goes from `before` to `after` and is there at settle_ms: at once, or by an exponential
/// that is within a hundredth by then.
std::vector<StepFrame> frames(double settle_ms, double period_ms, double phase_ms, bool slow,
                              double before, double after) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.002 * std::abs(after - before));
  std::vector<StepFrame> seen;
  for (double t = phase_ms - 5.0 * period_ms; t < 300.0; t += period_ms) {
    const double left = t < 0.0          ? 1.0
                        : slow           ? std::exp(-t * std::log(100.0) / settle_ms)
                        : t >= settle_ms ? 0.0
                                         : 1.0;
    seen.push_back({t, after + left * (before - after) + noise(random)});
  }
  return seen;
}

TEST(StepTime, IsWithinAFramePeriodOfTheTruth) {
  for (const double truth : {0.0, 7.0, 35.0, 100.0}) {
    for (const double phase : {0.5, 3.0, 9.5}) {
      const auto found = step_time(frames(truth, 10.0, phase, false, 20.0, -20.0), 20.0);
      ASSERT_TRUE(found) << found.error().reason;
      EXPECT_LE(found->after_ms, truth);
      EXPECT_GE(found->until_ms, truth);
      EXPECT_LE(found->until_ms - found->after_ms, 10.0 + 1e-9);
    }
  }
}

TEST(StepTime, OfASlowCrystalIsWhereItsLastPercentEnds) {
  const auto found = step_time(frames(60.0, 4.0, 1.0, true, 0.0, 50.0), 0.0);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_NEAR(found->until_ms, 60.0, 9.0);
}

TEST(StepTime, RefusesWhatDeterminesNothing) {
  EXPECT_EQ(step_time(frames(10.0, 60.0, 1.0, false, 0.0, 50.0), 0.0).error().field, "watch_ms");
  EXPECT_EQ(step_time(frames(250.0, 10.0, 1.0, true, 0.0, 50.0), 0.0).error().field, "watch_ms");
  EXPECT_FALSE(step_time(frames(10.0, 5.0, 1.0, false, 50.0, 51.0), 51.0));  // as before
  // The hologram before settles just when the next one is shown.
  std::vector<StepFrame> late;
  for (int k = -4; k < 20; ++k) late.push_back({10.0 * k + 1.0, k < -2 ? 0.0 : 50.0});
  EXPECT_EQ(step_time(late, 0.0).error().field, "watch_ms");
}

TEST(SettleTime, ProposesTheLongestAndAMargin) {
  const std::vector<StepTime> steps{{0.0, 8.0}, {5.0, 15.0}, {9.0, 19.0}};
  const SettleTime time = settle_time(steps);
  EXPECT_EQ(time.p50_ms, 15.0);
  EXPECT_EQ(time.max_ms, 19.0);
  EXPECT_EQ(time.worst_ms, 19.0);
  EXPECT_EQ(time.outliers, 0);
  EXPECT_EQ(time.mad_ms, 4.0);
  EXPECT_EQ(time.least_ms, 9.0);
  EXPECT_EQ(time.resolution_ms, 10.0);
  EXPECT_DOUBLE_EQ(time.margin_ms, 3.8);
  EXPECT_EQ(time.proposed_ms, 23.0);
  EXPECT_EQ(settle_time(std::vector<StepTime>{{0.0, 1.0}}).proposed_ms, 3.0);
}

/// Of 20 changes before a camera of 10 ms, the frames of six came late.
TEST(SettleTime, DelaysOfABusyMachineAreOutliers) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> phase(0.0, 10.0), late(20.0, 150.0);
  std::vector<StepTime> steps;
  for (int k = 0; k < 20; ++k) {
    const double until = 35.0 + phase(random) + (k % 3 == 1 && k < 18 ? late(random) : 0.0);
    steps.push_back({until - 10.0, until});
  }
  const SettleTime time = settle_time(steps);
  EXPECT_EQ(time.outliers, 6);
  EXPECT_GT(time.worst_ms, 80.0);
  EXPECT_GE(time.max_ms, 35.0);
  EXPECT_LE(time.max_ms, 45.0);
  EXPECT_LE(time.least_ms, 35.0);
  EXPECT_GE(time.proposed_ms, 42.0);
  EXPECT_LE(time.proposed_ms, 54.0);
}

}  // namespace
}  // namespace ovws
