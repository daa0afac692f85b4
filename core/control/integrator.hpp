/// The closed loop's control law: an integrator with leak for each mode, limits, and when to give
/// up.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

struct ModeGain {
  int j = 0;          ///< OSA index
  double gain = 0.0;  ///< of a step, 0 <= gain <= 1
  friend bool operator==(const ModeGain&, const ModeGain&) = default;
};

struct LoopSettings {
  double gain = 0.5;            ///< of a step: 0 < gain <= 1
  double leak = 0.0;            ///< part of the correction that is forgotten a step: 0 <= leak < 1
  std::vector<int> modes = {};  ///< OSA indices to correct; empty: all that are measured, j >= 1
  std::vector<ModeGain> gains = {};  ///< of single modes in place of `gain`
  double limit_waves = 5.0;          ///< of each mode's correction, RMS-normalised; > 0
  double patience_s = 2.0;           ///< without a usable frame, at the limit, or growing; > 0
  double growth = 3.0;               ///< times the residual's level of before: that is growing; > 1
  double floor_waves = 0.05;         ///< residual RMS below which it never counts as growing; >= 0
};

/// Errors (Errc::invalid, field as the key).
Result<void> check_loop(const LoopSettings& settings);

/// Why a loop opens by itself.
enum class LoopEnd { none, too_few_spots, at_limit, growing };

/// One step a usable frame: c <- (1 - leak) c + gain r, where r is the residual measured with the
/// correction c subtracted from the hologram. A mode at its limit stays there until its residual
/// leads back, so that nothing winds up. The level that growth is told against follows the residual
/// RMS downwards within `patience_s` and upwards within ten times that. Times are CLOCK_MONOTONIC.
/// For one thread.
class Integrator {
 public:
  /// Begins from `correction`, RMS-normalised waves; what of it is not corrected stays.
  Integrator(LoopSettings settings, std::vector<Mode> correction, std::int64_t now_ns);

  /// A usable frame: settled, valid, and of the hologram that shows the correction.
  /// `residual_waves` as `modes_j`.
  LoopEnd step(std::span<const int> modes_j, std::span<const float> residual_waves,
               std::int64_t now_ns);
  /// No usable frame came until now; lost spots were found at `found_ns` (0: never). Patience
  /// counts from then on, but ends after kMaxPatience times `patience_s`.
  LoopEnd wait(std::int64_t now_ns, std::int64_t found_ns = 0) const;
  static constexpr double kMaxPatience = 5.0;

  const std::vector<Mode>& correction() const { return correction_; }
  double residual_rms_waves() const { return residual_rms_waves_; }  ///< of the corrected modes
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
