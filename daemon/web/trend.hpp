/// What the wavefront did, half a second at a time: no frame's spike is missed by a browser that
/// sees only some frames.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace ovws::web {

constexpr std::int64_t kTrendBinNs = 500'000'000;

/// One thread at a time.
class Trend {
 public:
  /// Takes a `wavefront` message; returns the bin that it ended, if it ended one, as the message
  /// that a browser gets: `t_ns` its end, `span_s`, counts `frames`, `valid`, `gap`, the most spots
  /// lost in a frame `lost_max`, `rms_waves` (mean of valid frames, or null) and `rms_max_waves`,
  /// `latency_median_us`, `latency_max_us`, `j` and `coefficients` (means of valid frames, or
  /// null).
  std::optional<nlohmann::json> add(const nlohmann::json& wavefront);

 private:
  nlohmann::json ended(std::int64_t t_ns) const;
  void begin(std::int64_t t_ns);
  void add_valid(const nlohmann::json& wavefront);

  std::int64_t begin_ns_ = 0;
  int frames_ = 0;
  int valid_ = 0;
  std::int64_t gap_ = 0;
  int lost_max_ = 0;
  double rms_sum_ = 0.0;
  double rms_max_ = 0.0;
  std::vector<double> latencies_us_;
  std::vector<int> j_;
  std::vector<double> sums_;
};

}  // namespace ovws::web
