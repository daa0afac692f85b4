/// Interface of the control laws: each corrects one mode.
#pragma once

#include <complex>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace ovws {

/// Timing of a closed loop that takes one sample a step.
struct LoopTiming {
  double step_s = 0.0;  ///< from one step to the next
  /// From the middle of a sample's exposure to the middle of the time in which the correction
  /// computed from it is shown. With step_s, each correction is in the next sample.
  double delay_s = 0.0;
};

/// Transfer function of a delay: z^-1 for one step.
inline std::complex<double> delayed(double hz, double delay_s) {
  return std::polar(1.0, -2.0 * std::numbers::pi * hz * delay_s);
}

/// Residual of one mode in one frame, RMS-normalised waves.
struct ModeSample {
  std::int64_t t_ns = 0;        ///< about the middle of the frame's exposure, CLOCK_MONOTONIC
  double residual_waves = 0.0;  ///< measured residual
  double sigma_waves = 0.0;     ///< standard error of residual_waves; 0: unknown
  double shown_waves = 0.0;     ///< correction in the hologram of that frame
};

/// Control law of one mode. Not thread-safe.
class ModeLaw {
 public:
  virtual ~ModeLaw() = default;

  /// Takes a frame's residual. Frames must come in the order of their times.
  virtual void observe(const ModeSample& sample) = 0;
  /// Takes a step: returns the correction for the time `t_ns` (CLOCK_MONOTONIC), waves, from
  /// -`limit_waves` to `limit_waves`. `t_ns` is not before the last sample.
  virtual double step(std::int64_t t_ns, double limit_waves) = 0;
  /// Complementary sensitivity: correction over disturbance at the frequencies `hz`. The
  /// disturbance is rejected by 1 minus this value; noise is passed on with this value. Exact for a
  /// delay of whole steps; a delay that varies from step to step counts with its mean.
  virtual std::vector<std::complex<double>> transfer(std::span<const double> hz,
                                                     const LoopTiming& timing) const = 0;
};

}  // namespace ovws
