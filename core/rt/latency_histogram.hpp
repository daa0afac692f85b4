/// Always-on latency statistics: log-linear buckets, recorded without waiting.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/realtime.hpp"

namespace ovws {

/// Of all since the start: what is added up over any time and over several daemons.
struct LatencyTotals {
  /// Two an octave, from 8 us to 134 ms.
  static constexpr std::size_t kEdges = 29;
  /// Where they are, us, rising. They are edges of the histogram's buckets, too: the counts are
  /// exact.
  static const std::array<double, kEdges>& edges_us();

  std::uint64_t count = 0;
  double sum_us = 0.0;
  std::array<std::uint64_t, kEdges> below{};  ///< how many took less than the edge
};

struct LatencySummary {
  std::uint64_t count = 0;
  double p50_us = 0.0, p99_us = 0.0, p999_us = 0.0, max_us = 0.0;
  LatencyTotals since_start{};
};

/// Buckets of 1/16 of an octave from 64 ns to 64 s (values outside count in the first or last):
/// percentiles are right to 6.25 %. One or more recording threads, one reading thread.
class LatencyHistogram {
 public:
  void record(std::int64_t latency_ns) OVWS_NONBLOCKING;  ///< RT-safe
  /// Percentiles of all that was recorded since the last call, and starts anew; the totals go on.
  LatencySummary take();

 private:
  static constexpr int kSubBuckets = 16;
  static constexpr int kOctaves = 30;
  static constexpr std::size_t kBuckets = std::size_t(kSubBuckets) * kOctaves;
  std::array<std::atomic<std::uint32_t>, kBuckets> buckets_{};
  std::atomic<std::int64_t> max_ns_{0};
  std::atomic<std::int64_t> sum_ns_{0};  ///< since the last take
  LatencyTotals totals_;                 ///< the reading thread's
};

}  // namespace ovws
