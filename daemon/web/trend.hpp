/// Trend statistics of the wavefront in bins of time, so that browsers, which receive only some
/// frames, miss no peak.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace ovws::web {

constexpr std::int64_t kTrendBinNs = 500'000'000;      ///< for the last minutes
constexpr std::int64_t kHistoryBinNs = 5'000'000'000;  ///< for the last hour

/// Accumulates trend statistics. Use it from one thread at a time.
class Trend {
 public:
  explicit Trend(std::int64_t bin_ns) : bin_ns_(bin_ns) {}

  /// Adds a `wavefront` message. If it begins a new bin, returns the message for browsers about the
  /// bin that ended. `bin_s`: usual length of a bin. Over all frames: `t_ns` (end of the bin),
  /// `span_s`, `frames` and `gap` (frames received and lost), `lost_max` (most spots lost in one
  /// frame), `latency_median_us`, `latency_max_us`. `j`: modes of the last valid frame, [] without
  /// one. Over the valid frames since `j` last changed: `valid` (their number), `rms_waves` and
  /// `coefficients` (means), `rms_min_waves`, `rms_max_waves`; null without a valid frame. Waves
  /// are rounded to 1e-6, microseconds to 0.1.
  std::optional<nlohmann::json> add(const nlohmann::json& wavefront);

 private:
  nlohmann::json ended(std::int64_t t_ns) const;
  void begin(std::int64_t t_ns);
  void add_valid(const nlohmann::json& wavefront);

  std::int64_t bin_ns_;
  std::int64_t begin_ns_ = 0;
  int frames_ = 0;
  int valid_ = 0;
  std::int64_t gap_ = 0;
  int lost_max_ = 0;
  double rms_sum_ = 0.0;
  double rms_min_ = 0.0;
  double rms_max_ = 0.0;
  std::vector<double> latencies_us_;
  std::vector<int> j_;
  std::vector<double> sums_;
};

}  // namespace ovws::web
