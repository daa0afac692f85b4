/// Latency histogram with log-linear buckets; recording is lock-free and always on.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/realtime.hpp"

namespace ovws {

/// Cumulative counts since the start, which can be summed over time and over several daemons.
struct LatencyTotals {
  /// Two edges per octave, from 8 us to 134 ms.
  static constexpr std::size_t kEdges = 29;
  /// The edges in us, ascending. Each is also an edge of the histogram's buckets, so the counts are
  /// exact.
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

/// 16 buckets per octave from 64 ns to 69 s; values outside count in the first or last bucket.
/// Percentiles are accurate to 6.25 %. Any number of recording threads, one reading thread.
class LatencyHistogram {
 public:
  void record(std::int64_t latency_ns) OVWS_NONBLOCKING;  ///< RT-safe
  /// Percentiles of the values recorded since the last call; resets them, but not the totals.
  LatencySummary take();

 private:
  static constexpr int kSubBuckets = 16;
  static constexpr int kOctaves = 30;
  static constexpr std::size_t kBuckets = std::size_t(kSubBuckets) * kOctaves;
  std::array<std::atomic<std::uint32_t>, kBuckets> buckets_{};
  std::atomic<std::int64_t> max_ns_{0};
  std::atomic<std::int64_t> sum_ns_{0};  ///< since the last take
  LatencyTotals totals_;                 ///< reading thread only
};

}  // namespace ovws
