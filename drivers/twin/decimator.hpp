/// Decimation of the field on the SLM: a narrow window of the far field needs fewer samples.
#pragma once

#include <complex>

#include "core/base/image.hpp"
#include "drivers/twin/line_filter.hpp"

namespace ovws::twin {

/// Low-pass filter along one axis, whose output is sampled at a wider spacing. The Fourier sum of
/// the values, times gain(), is that of the samples at any frequency up to `half_band_cpp`, within
/// 1e-4 of the strongest one. Immutable.
class Decimator {
 public:
  /// `inputs`: number of samples. `half_band_cpp`: highest frequency needed, cycles per sample.
  /// `step_cpp`: step of the frequencies needed. 1 / (step_cpp spacing()) is a fast FFT length,
  /// unless spacing() is 1: then the samples are kept as they are.
  Decimator(int inputs, double half_band_cpp, double step_cpp);

  double spacing() const { return spacing_; }  ///< of the values, samples
  int outputs() const { return outputs_; }
  /// Sample number, possibly outside [0, inputs), at which value `k` is centred. The values are
  /// symmetric about the middle of the samples.
  double position(int k) const {
    return 0.5 * (inputs_ - 1) + (k - 0.5 * (outputs_ - 1)) * spacing_;
  }
  static constexpr int kMaxReach = 40;  ///< samples; farther than any value from the first sample

  /// Filters all columns of an image with `inputs` or more rows: `out` receives outputs() rows.
  void down(const Image<std::complex<float>>& in, std::complex<float>* out) const;

  /// Factor from the Fourier sum of the values, with positions relative to their middle, to that of
  /// the samples relative to theirs. `cpp`: frequency, cycles per sample.
  float gain(double cpp) const;

 private:
  double weight(double from_centre) const;

  int inputs_;
  double spacing_, reach_ = 0.0;
  int outputs_;
  LineFilter taps_;
};

}  // namespace ovws::twin
