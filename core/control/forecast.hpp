/// What a control law will leave of a disturbance, and how safe it is.
#pragma once

#include "core/control/disturbance.hpp"
#include "core/control/mode_law.hpp"

namespace ovws {

struct LoopForecast {
  double residual_waves = 0.0;  ///< RMS that is left, noise included that the loop passes on
  /// Least error of the correction's size that can make the loop unstable: 1 over the greatest
  /// complementary sensitivity (small-gain theorem). 0.5: the correction on the SLM may be half or
  /// one and a half of what is computed.
  double gain_margin = 0.0;
};

/// Forecast for one mode: integrals over frequency of the disturbance's and the noise's power with
/// the law's transfer function.
LoopForecast forecast(const ModeLaw& law, const Disturbance& disturbance, const LoopTiming& timing);

/// Gain of the integrator that leaves least of the disturbance (modal gain optimisation; Gendron
/// and Lena, A&A 291, 337, 1994), of those with a gain margin of at least `least_margin`.
/// `disturbance`: with the noise of one frame; a step has `frames` frames.
double best_gain(const Disturbance& disturbance, const LoopTiming& timing, double leak,
                 double least_margin, double frames = 1.0);

}  // namespace ovws
