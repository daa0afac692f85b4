/// Detects a closed loop that fails.
#pragma once

#include <cstdint>
#include <optional>

#include "core/control/loop_settings.hpp"

namespace ovws {

/// Why the loop opened by itself. too_few_spots: no usable frame for `patience_s`. at_limit: a mode
/// stayed at its correction limit. growing: the residual RMS kept growing.
enum class LoopEnd { none, too_few_spots, at_limit, growing };

/// Watch over a closed loop. The loop ends if the residual RMS exceeds `growth` times its low-pass
/// filtered level, and `floor_waves`, for `patience_s` without interruption. The filter's time
/// constant is `patience_s` for a falling residual, and ten times that for a rising one. Times are
/// CLOCK_MONOTONIC ns. Not thread-safe.
class LoopWatch {
 public:
  LoopWatch(const LoopSettings& settings, std::int64_t now_ns);

  /// Call at each step: why the loop must open. `at_limit`: a correction was limited.
  LoopEnd step(double residual_rms_waves, bool at_limit, std::int64_t now_ns);
  /// Call it when no usable frame came until `now_ns`. The loop ends `patience_s` after the last
  /// step or after `found_ns`, whichever is later, and at the latest kMaxPatience times
  /// `patience_s` after the last step. `found_ns`: time at which a search last found lost spots; 0:
  /// never.
  LoopEnd wait(std::int64_t now_ns, std::int64_t found_ns = 0) const;
  static constexpr double kMaxPatience = 5.0;

 private:
  void follow_level(double residual_rms_waves, std::int64_t now_ns);
  bool lasts(bool condition, std::optional<std::int64_t>& since_ns, std::int64_t now_ns) const;

  double patience_s_, growth_, floor_waves_;
  std::optional<double> level_waves_;
  std::int64_t t_last_ns_ = 0;
  std::optional<std::int64_t> at_limit_since_ns_, growing_since_ns_;
};

}  // namespace ovws
