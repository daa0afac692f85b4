/// Model of a mode's disturbance over time, identified from its power spectrum.
#pragma once

#include <vector>

#include "core/control/oscillator.hpp"
#include "core/control/spectrum.hpp"

namespace ovws {

/// Disturbance of one mode: a sum of independent oscillators, and the noise of its measurement.
struct Disturbance {
  static constexpr int kMaxParts = 8;

  std::vector<Oscillator> parts;  ///< at most kMaxParts, the strongest first
  double noise_waves = 0.0;       ///< RMS noise of one frame's coefficient

  double rms_waves() const;  ///< RMS of the disturbance, without noise
  /// One-sided power spectral density of samples without noise, wave^2/Hz.
  double sampled_power_per_hz(double hz, double step_s) const;
};

/// Identifies the disturbance whose samples have this spectrum. `step_s`: interval of the samples.
/// `sigma_waves`: their standard error, the least noise that is assumed. The powers of a set of
/// oscillators and of the noise maximise the likelihood of the spectrum (multiplicative updates for
/// the Itakura-Saito divergence; Fevotte and others, Neural Computation 21, 793, 2009). The set has
/// frequencies from half a segment's to half the highest of the spectrum, four dampings, and a
/// narrow line at each peak. Takes some 10 ms. No parts if the spectrum is empty.
Disturbance identify(const Spectrum& spectrum, double step_s, double sigma_waves);

}  // namespace ovws
