/// Control law of the closed loop: a leaky integrator for each mode, with anti-windup limits and
/// detection of a loop that fails.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/optics/zernike.hpp"

namespace ovws {

struct ModeGain {
  int j = 0;          ///< OSA index
  double gain = 0.0;  ///< integrator gain, 0 <= gain <= 1
  friend bool operator==(const ModeGain&, const ModeGain&) = default;
};

struct LoopSettings {
  double gain = 0.5;            ///< integrator gain, 0 < gain <= 1
  double leak = 0.0;            ///< fraction of the correction that decays per step, 0 <= leak < 1
  std::vector<int> modes = {};  ///< OSA indices to correct; empty: all measured modes, j >= 1
  std::vector<ModeGain> gains = {};  ///< gains of single modes, instead of `gain`
  double limit_waves = 5.0;          ///< limit of each mode's correction, RMS-normalised; > 0
  double patience_s = 5.0;    ///< time-out without a usable frame, at the limit, or growing; > 0
  double growth = 3.0;        ///< ratio of residual to its past level that counts as growing; > 1
  double floor_waves = 0.05;  ///< residual RMS below which growth is ignored; >= 0
};

/// Why the loop opened by itself. too_few_spots: no usable frame for `patience_s`. at_limit: a mode
/// stayed at its correction limit. growing: the residual RMS kept growing.
enum class LoopEnd { none, too_few_spots, at_limit, growing };

/// Leaky integrator, one step per usable frame: c <- (1 - leak) c + gain r, where r is the residual
/// measured with the correction c subtracted from the hologram. Clamping c itself prevents
/// integrator windup. The loop ends if the residual RMS exceeds `growth` times its low-pass
/// filtered level, and `floor_waves`, for `patience_s` without interruption. The filter's time
/// constant is `patience_s` for a falling residual, and ten times that for a rising one. Times are
/// CLOCK_MONOTONIC ns. Not thread-safe.
class Integrator {
 public:
  /// Starts from `correction`, RMS-normalised waves; modes that are not corrected keep their value.
  Integrator(LoopSettings settings, std::vector<Mode> correction, std::int64_t now_ns);

  /// Processes a usable frame: settled, valid, and taken with the hologram that shows the
  /// correction. `residual_waves` holds the modes `modes_j`, in that order. Returns why the loop
  /// must open.
  LoopEnd step(std::span<const int> modes_j, std::span<const float> residual_waves,
               std::int64_t now_ns);
  /// Call it when no usable frame came until `now_ns`. The loop ends `patience_s` after the last
  /// step or after `found_ns`, whichever is later, and at the latest kMaxPatience times
  /// `patience_s` after the last step. `found_ns`: time at which a search last found lost spots; 0:
  /// never.
  LoopEnd wait(std::int64_t now_ns, std::int64_t found_ns = 0) const;
  static constexpr double kMaxPatience = 5.0;

  const std::vector<Mode>& correction() const { return correction_; }
  double residual_rms_waves() const { return residual_rms_waves_; }  ///< over the corrected modes
  std::int64_t steps() const { return steps_; }

 private:
  void follow_level(std::int64_t now_ns);
  double gain_of(int j) const;
  bool is_corrected(int j) const;
  Mode& mode(int j);
  bool lasts(bool condition, std::optional<std::int64_t>& since_ns, std::int64_t now_ns) const;

  LoopSettings settings_;
  std::vector<Mode> correction_;
  double residual_rms_waves_ = 0.0;
  double level_waves_ = 0.0;
  std::int64_t steps_ = 0;
  std::int64_t t_last_ns_ = 0;
  std::optional<std::int64_t> at_limit_since_ns_, growing_since_ns_;
};

}  // namespace ovws
