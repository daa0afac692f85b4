/// What was identified of a loop's disturbance, mode by mode, and what the control laws make of it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/control/forecast.hpp"

namespace ovws {

struct ModeModel {
  int j = 0;  ///< OSA index
  Disturbance disturbance;
  double best_gain = 0.0;                         ///< of an integrator
  LoopForecast integrator, optimised, predictor;  ///< with the gain asked for; best_gain; Predictor
};

struct LoopModel {
  /// Least gain margin (see LoopForecast) with which a law is used.
  static constexpr double kLeastMargin = 0.5;

  std::int64_t t_taken_ns = 0;  ///< UTC
  double seconds = 0.0;         ///< length of the series
  LoopTiming timing;            ///< of the loop for which the forecasts are
  int measured_steps = 0;       ///< steps whose mean the timing is; 0: it is an estimate
  std::vector<ModeModel> modes;

  const ModeModel* find(int j) const;
};

/// Disturbances of some modes: residuals plus shown corrections, averages of a few frames each.
struct DisturbanceSeries {
  std::vector<int> modes_j;
  ModeSeries waves;                 ///< in the order of modes_j
  std::vector<double> sigma_waves;  ///< standard errors of single frames, in the order of modes_j
  double frames_per_sample = 1.0;   ///< on average, >= 1
};

/// Identifies each mode's disturbance, and forecasts the laws for a loop with this timing. `gain`,
/// `leak`: those of the integrator. A predictor whose gain margin would be less than kLeastMargin
/// is made more cautious: more noise is assumed than was found. Takes some 0.1 s a mode; `go_on`
/// gets the share that is done before each. No modes: the series has fewer than 64 samples, or its
/// gaps leave none for a spectrum, or `go_on` returned false.
LoopModel identify(const DisturbanceSeries& series, const LoopTiming& timing, double gain,
                   double leak, const std::function<bool(double)>& go_on = nullptr);

}  // namespace ovws
