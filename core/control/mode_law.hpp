/// Interface of the control laws: each corrects one mode.
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

namespace ovws {

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
  /// Correction for the time `t_ns` (CLOCK_MONOTONIC), waves. `t_ns` is not before the last sample.
  /// The caller may limit the correction: `shown_waves` of later samples tells the law what was
  /// shown.
  virtual double correction_at(std::int64_t t_ns) const = 0;
  /// Complementary sensitivity: correction over disturbance at the frequencies `hz`, for a loop
  /// with one sample a step and a step every `step_s`. Each correction is in the next sample. The
  /// disturbance is rejected by 1 minus this value; noise is passed on with this value.
  virtual std::vector<std::complex<double>> transfer(std::span<const double> hz,
                                                     double step_s) const = 0;
};

}  // namespace ovws
