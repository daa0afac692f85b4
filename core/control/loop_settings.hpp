/// Settings of the closed loop.
#pragma once

#include <cstdint>
#include <vector>

namespace ovws {

struct ModeGain {
  int j = 0;          ///< OSA index
  double gain = 0.0;  ///< integrator gain, 0 <= gain <= 1
  friend bool operator==(const ModeGain&, const ModeGain&) = default;
};

struct ModeOffset {
  int j = 0;           ///< OSA index
  double waves = 0.0;  ///< residual to hold, RMS-normalised
  friend bool operator==(const ModeOffset&, const ModeOffset&) = default;
};

/// Control laws by name.
enum class LawName : std::uint8_t {
  integrator,  ///< leaky integrator with `gain` and `gains`
  optimised,   ///< leaky integrator with the best gain of each mode, as identified
  predictor,   ///< Kalman filter of each mode's disturbance, as identified
};

struct LoopSettings {
  LawName law = LawName::integrator;
  double gain = 0.5;            ///< integrator gain, 0 < gain <= 1
  double leak = 0.0;            ///< fraction of the correction that decays per step, 0 <= leak < 1
  std::vector<int> modes = {};  ///< OSA indices to correct; empty: all measured modes, j >= 1
  std::vector<ModeGain> gains = {};      ///< gains of single modes, instead of `gain`
  std::vector<ModeOffset> offsets = {};  ///< residuals to hold instead of 0
  double limit_waves = 5.0;              ///< limit of each mode's correction, RMS-normalised; > 0
  double patience_s = 5.0;    ///< time-out without a usable frame, at the limit, or growing; > 0
  double growth = 3.0;        ///< ratio of residual to its past level that counts as growing; > 1
  double floor_waves = 0.05;  ///< residual RMS below which growth is ignored; >= 0
};

}  // namespace ovws
