/// The schedule of image searches, tested with injected time.
#include "daemon/ovwsd/sensor/search_policy.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

constexpr std::int64_t kMs = 1'000'000;

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

}  // namespace
}  // namespace ovws
