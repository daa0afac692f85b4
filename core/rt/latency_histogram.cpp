/// Bucket index of a latency, and percentiles from the bucket counts.
#include "core/rt/latency_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace ovws {
namespace {

constexpr int kFirstOctaveBit = 6;    // the first bucket begins at 2^6 ns
constexpr int kSubBits = 4;           // log2 of the 16 buckets per octave
constexpr int kFirstEdgeBit = 13;     // the first edge of LatencyTotals is 2^13 ns
constexpr std::size_t kEdgeStep = 8;  // LatencyTotals has an edge at every eighth bucket

std::size_t bucket_of(std::int64_t latency_ns, std::size_t bucket_count) {
  const auto ns = std::uint64_t(std::max<std::int64_t>(latency_ns, 1 << kFirstOctaveBit));
  const int top_bit = int(std::bit_width(ns)) - 1;
  const std::uint64_t sub = (ns >> (top_bit - kSubBits)) & ((1U << kSubBits) - 1U);
  const std::size_t bucket = (std::size_t(top_bit - kFirstOctaveBit) << kSubBits) + sub;
  return std::min(bucket, bucket_count - 1);
}

/// Latency in us at a position inside a bucket. `fraction` 0 is the bucket's lower edge; 0.5 is its
/// centre, so that a percentile is wrong by at most half the bucket's width.
double latency_us(std::size_t bucket, double fraction) {
  const double octave = std::ldexp(1.0, kFirstOctaveBit + int(bucket >> kSubBits));
  const double sub = double(bucket & ((1U << kSubBits) - 1U)) + fraction;
  return octave * (1.0 + sub / double(1U << kSubBits)) / 1000.0;
}

/// Index of the bucket that begins at edge number `edge` of LatencyTotals.
constexpr std::size_t bucket_at(std::size_t edge) {
  return (std::size_t(kFirstEdgeBit - kFirstOctaveBit) << kSubBits) + edge * kEdgeStep;
}

}  // namespace

const std::array<double, LatencyTotals::kEdges>& LatencyTotals::edges_us() {
  static const auto edges = [] {
    std::array<double, kEdges> made{};
    for (std::size_t e = 0; e < kEdges; ++e) made[e] = latency_us(bucket_at(e), 0.0);
    return made;
  }();
  return edges;
}

void LatencyHistogram::record(std::int64_t latency_ns) OVWS_NONBLOCKING {
  buckets_[bucket_of(latency_ns, buckets_.size())].fetch_add(1, std::memory_order_relaxed);
  sum_ns_.fetch_add(std::max<std::int64_t>(latency_ns, 0), std::memory_order_relaxed);
  std::int64_t seen = max_ns_.load(std::memory_order_relaxed);
  while (latency_ns > seen &&
         !max_ns_.compare_exchange_weak(seen, latency_ns, std::memory_order_relaxed)) {
  }
}

LatencySummary LatencyHistogram::take() {
  std::array<std::uint32_t, kBuckets> counts{};
  LatencySummary summary;
  for (std::size_t b = 0; b < counts.size(); ++b) {
    counts[b] = buckets_[b].exchange(0, std::memory_order_relaxed);
    summary.count += counts[b];
  }
  summary.max_us = double(max_ns_.exchange(0, std::memory_order_relaxed)) / 1000.0;
  totals_.count += summary.count;
  totals_.sum_us += double(sum_ns_.exchange(0, std::memory_order_relaxed)) / 1000.0;
  std::uint64_t below = 0;
  for (std::size_t e = 0, bucket = 0; e < LatencyTotals::kEdges; ++e) {
    while (bucket < bucket_at(e)) below += counts[bucket++];
    totals_.below[e] += below;
  }
  summary.since_start = totals_;
  if (summary.count == 0) return summary;

  const auto percentile_us = [&](double fraction) {
    const auto rank = std::uint64_t(std::ceil(fraction * double(summary.count)));
    std::uint64_t seen = 0;
    std::size_t bucket = 0;
    while (bucket + 1 < counts.size() && (seen += counts[bucket]) < rank) ++bucket;
    return std::min(latency_us(bucket, 0.5), summary.max_us);
  };
  summary.p50_us = percentile_us(0.5);
  summary.p99_us = percentile_us(0.99);
  summary.p999_us = percentile_us(0.999);
  return summary;
}

}  // namespace ovws
