/// The latency histogram recovers percentiles of known distributions within its stated 6.25 %.
#include "core/rt/latency_histogram.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace ovws {
namespace {

constexpr double kRelative = 0.0625;

TEST(LatencyHistogram, NothingRecordedIsAllZero) {
  LatencyHistogram histogram;
  const LatencySummary summary = histogram.take();
  EXPECT_EQ(summary.count, 0U);
  EXPECT_EQ(summary.p50_us, 0.0);
  EXPECT_EQ(summary.max_us, 0.0);
}

TEST(LatencyHistogram, PercentilesOfAUniformDistributionAreRightTo6Percent) {
  LatencyHistogram histogram;
  for (int us = 1; us <= 10000; ++us) histogram.record(us * 1000LL);
  const LatencySummary summary = histogram.take();
  EXPECT_EQ(summary.count, 10000U);
  EXPECT_NEAR(summary.p50_us, 5000.0, 5000.0 * kRelative);
  EXPECT_NEAR(summary.p99_us, 9900.0, 9900.0 * kRelative);
  EXPECT_NEAR(summary.p999_us, 9990.0, 9990.0 * kRelative);
  EXPECT_EQ(summary.max_us, 10000.0);
}

TEST(LatencyHistogram, OneSlowFrameInAThousandIsSeenInMaxAndNotInP99) {
  LatencyHistogram histogram;
  for (int i = 0; i < 999; ++i) histogram.record(100'000);
  histogram.record(50'000'000);
  const LatencySummary summary = histogram.take();
  EXPECT_NEAR(summary.p99_us, 100.0, 100.0 * kRelative);
  EXPECT_NEAR(summary.p999_us, 100.0, 100.0 * kRelative);
  EXPECT_EQ(summary.max_us, 50'000.0);
}

TEST(LatencyHistogram, EveryMagnitudeFrom64NsTo64SIsRightTo6Percent) {
  for (double ns = 64.0; ns < 6.4e10; ns *= 1.37) {
    LatencyHistogram histogram;
    const auto value = std::int64_t(std::llround(ns));
    histogram.record(value);
    histogram.record(value * 100);  // so that p50 is the bucket's own value, not clipped by max
    EXPECT_NEAR(histogram.take().p50_us, double(value) * 1e-3, double(value) * 1e-3 * kRelative);
  }
}

TEST(LatencyHistogram, ValuesOutsideCountInTheFirstOrLastBucket) {
  LatencyHistogram histogram;
  histogram.record(-5);
  histogram.record(0);
  histogram.record(std::int64_t(1) << 62);
  const LatencySummary summary = histogram.take();
  EXPECT_EQ(summary.count, 3U);
  EXPECT_LT(summary.p50_us, 0.07);
  EXPECT_GT(summary.p99_us, 6e7);
}

TEST(LatencyHistogram, TakeStartsAnew) {
  LatencyHistogram histogram;
  histogram.record(1'000'000);
  EXPECT_EQ(histogram.take().count, 1U);
  histogram.record(2'000);
  const LatencySummary summary = histogram.take();
  EXPECT_EQ(summary.count, 1U);
  EXPECT_EQ(summary.max_us, 2.0);
}

TEST(LatencyHistogram, TotalsGoOnAndAreExactAtTheirEdges) {
  const auto& edges = LatencyTotals::edges_us();
  EXPECT_EQ(edges.front(), 8.192);
  EXPECT_EQ(edges[1], 12.288);
  EXPECT_EQ(edges.back(), 134217.728);
  LatencyHistogram histogram;
  double sum_us = 0.0;
  for (int round = 1; round <= 2; ++round) {
    for (const double edge : edges) {
      const auto ns = std::int64_t(std::llround(edge * 1000.0));
      histogram.record(ns - 1);
      histogram.record(ns);
      sum_us += double(2 * ns - 1) / 1000.0;
    }
    const LatencyTotals totals = histogram.take().since_start;
    EXPECT_EQ(totals.count, round * 2 * edges.size());
    EXPECT_NEAR(totals.sum_us, sum_us, 1e-6 * sum_us);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      EXPECT_EQ(totals.below[e], round * (2 * e + 1)) << edges[e];
    }
  }
}

TEST(LatencyHistogram, NothingIsLostWhileItIsTakenByAnotherThread) {
  LatencyHistogram histogram;
  constexpr int kRecords = 50000;
  std::thread recorder([&] {
    for (int i = 0; i < kRecords; ++i) histogram.record(i);
  });
  std::uint64_t seen = 0;
  for (int i = 0; i < 100; ++i) seen += histogram.take().count;
  recorder.join();
  seen += histogram.take().count;
  EXPECT_EQ(seen, std::uint64_t(kRecords));
}

}  // namespace
}  // namespace ovws
