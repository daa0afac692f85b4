/// The schedule of image searches, tested with injected time; and when templates have drifted.
#include "daemon/ovwsd/fitter/search_policy.hpp"

#include <gtest/gtest.h>

#include "tests/support/time.hpp"

namespace ovws {
namespace {

using test::kMs;

/// Runs the policy for `ms` milliseconds, polled every 10 ms; each search takes `takes_ms`.
struct Clock {
  SearchPolicy policy;
  std::int64_t now_ns = 5000 * kMs;
  int searches = 0;

  void run(std::int64_t ms, Doubt doubt, bool changes, std::int64_t takes_ms = 70) {
    for (const std::int64_t end_ns = now_ns + ms * kMs; now_ns < end_ns; now_ns += 10 * kMs) {
      if (!policy.is_due(doubt, changes, now_ns)) continue;
      policy.begin(changes);
      now_ns += takes_ms * kMs;
      policy.end(now_ns);
      ++searches;
    }
  }
};

TEST(SearchPolicy, SearchesAtOnceWhenValidityIsLost) {
  SearchPolicy policy;
  EXPECT_FALSE(policy.is_due(Doubt::none, true, 0));
  EXPECT_TRUE(policy.is_due(Doubt::blind, false, 0));
  EXPECT_TRUE(policy.is_due(Doubt::partial, false, 0));
}

TEST(SearchPolicy, SearchesBackToBackWhileWhatIsSeenChanges) {
  Clock clock;
  clock.run(2000, Doubt::blind, true);
  EXPECT_GE(clock.searches, 24);
}

TEST(SearchPolicy, SearchesTwiceASecondAtMostWhileFramesAreValid) {
  Clock clock;
  clock.run(5000, Doubt::partial, true);
  EXPECT_GE(clock.searches, 8);
  EXPECT_LE(clock.searches, 11);
}

TEST(SearchPolicy, BacksOffToHalfAMinuteWhileNothingChanges) {
  Clock clock;
  clock.run(60'000, Doubt::blind, false);
  EXPECT_GE(clock.searches, 7);
  EXPECT_LE(clock.searches, 10);
  const int before = clock.searches;
  clock.run(300'000, Doubt::blind, false);
  EXPECT_GE(clock.searches - before, 9);
  EXPECT_LE(clock.searches - before, 11);
}

TEST(SearchPolicy, AChangeEndsTheLongestPauseAtOnce) {
  Clock clock;
  clock.run(120'000, Doubt::blind, false);
  EXPECT_FALSE(clock.policy.is_due(Doubt::blind, false, clock.now_ns));
  EXPECT_TRUE(clock.policy.is_due(Doubt::blind, true, clock.now_ns));
  const int before = clock.searches;
  clock.run(80, Doubt::blind, true);
  clock.run(1000, Doubt::blind, false);
  EXPECT_GE(clock.searches - before, 3);  // the pauses are short again
}

TEST(SearchPolicy, CountsTriesOfTheSameImage) {
  Clock clock;
  clock.run(5000, Doubt::blind, false);
  EXPECT_EQ(clock.policy.tries(), clock.searches);
  EXPECT_GT(clock.policy.next_ns(), clock.now_ns - SearchPolicy::kMaxPauseNs);
  clock.policy.begin(true);
  clock.policy.end(clock.now_ns);
  EXPECT_EQ(clock.policy.tries(), 1);
  clock.policy.reset();
  EXPECT_EQ(clock.policy.tries(), 0);
}

constexpr TemplateDrift kNear{.drift_waves = 0.015,
                              .sigma_waves = 0.001,
                              .residual = 1.0,
                              .point_residual = 1.0,
                              .in_air = false};

TemplateDrift drifted_by(double waves) {
  TemplateDrift frame = kNear;
  frame.drift_waves = waves;
  return frame;
}

TEST(IsDrifted, AFarWavefrontNeedsNewTemplates) {
  EXPECT_FALSE(is_drifted(kNear));
  EXPECT_TRUE(is_drifted(drifted_by(0.021)));
}

TEST(IsDrifted, NoiseAloneIsNoDrift) {
  TemplateDrift dim = drifted_by(0.055);
  dim.sigma_waves = 0.02;
  EXPECT_FALSE(is_drifted(dim));
  dim.drift_waves = 0.065;
  EXPECT_TRUE(is_drifted(dim));
}

TEST(IsDrifted, AResidualAboveNoiseAllowsLittleDrift) {
  TemplateDrift bent = drifted_by(0.005);
  bent.residual = 1.6;
  EXPECT_TRUE(is_drifted(bent));
  bent.drift_waves = 0.0025;
  EXPECT_FALSE(is_drifted(bent)) << "within three standard errors";
  bent.drift_waves = 0.005;
  bent.point_residual = 1.4;
  EXPECT_FALSE(is_drifted(bent)) << "new templates would leave as much";
}

TEST(IsDrifted, InAirAResidualThatChangesIsEnough) {
  TemplateDrift air = kNear;
  air.in_air = true;
  EXPECT_FALSE(is_drifted(air));
  air.residual = 0.65;
  EXPECT_TRUE(is_drifted(air)) << "the air has calmed";
  air.residual = 1.55;
  EXPECT_TRUE(is_drifted(air)) << "it has become stronger";
}

TEST(IsDrifted, InAirNoiseHidesNoFarWavefront) {
  TemplateDrift air = drifted_by(0.055);
  air.sigma_waves = 0.1;
  EXPECT_FALSE(is_drifted(air));
  air.in_air = true;
  EXPECT_TRUE(is_drifted(air));
}

TEST(GivingUp, WaitsForThreeSecondsOfFailures) {
  GivingUp policy;
  EXPECT_FALSE(policy.failed(false, 1000 * kMs, 1500 * kMs, 100, 90));
  EXPECT_FALSE(policy.failed(false, 2000 * kMs, 3900 * kMs, 100, 90));
  EXPECT_TRUE(policy.failed(false, 3900 * kMs, 4100 * kMs, 100, 90));
  policy.reset();
  EXPECT_FALSE(policy.failed(false, 4100 * kMs, 4200 * kMs, 100, 90));
}

/// A wavefront that positions do not explain may be followed by one that they measure wrong.
TEST(GivingUp, CountsPositionsOnlyWhereTheyExplainMostFrames) {
  GivingUp policy;
  EXPECT_FALSE(policy.failed(false, 1000 * kMs, 5000 * kMs, 100, 40));
  EXPECT_TRUE(policy.failed(false, 5000 * kMs, 5100 * kMs, 100, 60));
  EXPECT_TRUE(policy.failed(true, 5100 * kMs, 5200 * kMs, 100, 30));
  EXPECT_FALSE(policy.failed(true, 5200 * kMs, 5300 * kMs, 100, 20));
  EXPECT_FALSE(policy.failed(false, 5300 * kMs, 5400 * kMs, 0, 0));
}

TEST(GivingUp, StaysGivenUpAfterAJob) {
  GivingUp policy;
  policy.reset();
  EXPECT_TRUE(policy.failed(true, 1000 * kMs, 1100 * kMs, 100, 90));
}

}  // namespace
}  // namespace ovws
