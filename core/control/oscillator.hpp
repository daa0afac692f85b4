/// The damped oscillator, of which models of a disturbance are made.
#pragma once

#include <Eigen/Core>

namespace ovws {

/// Random motion of a damped oscillator that white noise drives. With little damping: a vibration.
/// With the damping 1: motion without a preferred frequency, as of air, which is correlated over
/// about 1 / (2 pi hz) seconds. The state is the position in waves and the velocity in waves/s.
struct Oscillator {
  double hz = 1.0;         ///< natural frequency, > 0
  double damping = 1.0;    ///< damping ratio: 0 < damping <= 1
  double rms_waves = 0.0;  ///< RMS of the position

  /// One-sided power spectral density of the position, wave^2/Hz: its integral over all
  /// frequencies is rms_waves^2.
  double power_per_hz(double at_hz) const;
  /// The same for samples of the position at every `step_s`, up to half the sampling frequency:
  /// includes the aliases of higher frequencies.
  double sampled_power_per_hz(double at_hz, double step_s) const;
  /// Matrix that moves the state by `seconds` >= 0 if nothing drives the oscillator.
  Eigen::Matrix2d transition(double seconds) const;
  /// Variances of position and velocity; their covariance is 0.
  Eigen::Vector2d variances() const;
};

}  // namespace ovws
