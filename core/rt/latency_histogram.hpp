/// Latency histogram with log-linear buckets; recording is lock-free and always on.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/realtime.hpp"

namespace ovws {

/// Cumulative latency counts since the start. Unlike percentiles, these counts of several daemons
/// can be added.
struct LatencyTotals {
  /// Number of bucket edges: two per octave, from 8 us to 134 ms.
  static constexpr std::size_t kEdges = 29;
  /// Bucket edges in us, ascending. Each is also a bucket edge of LatencyHistogram, so the counts
  /// are exact.
  static const std::array<double, kEdges>& edges_us();

  std::uint64_t count = 0;
  double sum_us = 0.0;
  std::array<std::uint64_t, kEdges> below{};  ///< number of latencies below each edge
};

struct LatencySummary {
  std::uint64_t count = 0;
  double p50_us = 0.0, p99_us = 0.0, p999_us = 0.0, max_us = 0.0;
  LatencyTotals since_start{};
};

/// Histogram with 16 buckets per octave from 64 ns to 69 s. Values outside this range count in the
/// first or last bucket. Percentiles are accurate to 6.25 %. Any number of threads may call record;
/// only one thread may call take.
class LatencyHistogram {
 public:
  void record(std::int64_t latency_ns) OVWS_NONBLOCKING;  ///< RT-safe
  /// Returns the percentiles of the latencies recorded since the last call and clears the buckets.
  /// The totals since the start continue.
  LatencySummary take();

 private:
  static constexpr int kSubBuckets = 16;
  static constexpr int kOctaves = 30;
  static constexpr std::size_t kBuckets = std::size_t(kSubBuckets) * kOctaves;
  std::array<std::atomic<std::uint32_t>, kBuckets> buckets_{};
  std::atomic<std::int64_t> max_ns_{0};
  std::atomic<std::int64_t> sum_ns_{0};  ///< sum of latencies since the last take()
  LatencyTotals totals_;                 ///< used only by the thread that calls take()
};

}  // namespace ovws
