/// Decimation of the field on the SLM: a narrow window of the far field needs fewer samples.
#pragma once

#include <complex>
#include <vector>

#include "core/base/image.hpp"

namespace ovws::twin {

/// Low-pass filter along one axis, of which every bin()-th value is kept. The Fourier sum of the
/// values, times gain(), is that of the samples at any frequency up to `half_band_cpp`, within 1e-4
/// of the strongest one. Immutable.
class Decimator {
 public:
  /// `inputs`: number of samples. `half_band_cpp`: highest frequency needed, cycles per sample. At
  /// bin() 1 the samples are kept as they are.
  Decimator(int inputs, double half_band_cpp);

  int bin() const { return bin_; }
  int outputs() const { return outputs_; }
  /// Sample number, possibly outside [0, inputs), at which value `k` is centred.
  int position(int k) const { return bin_ * k - reach(); }
  /// Number of samples that a value depends on, on each side of its position.
  int reach() const { return int(taps_.size()) / 2; }
  static constexpr int kMaxReach = 27;

  /// Filters one line: `inputs` samples to outputs() values.
  void along(const std::complex<float>* in, std::complex<float>* out) const;
  /// Filters all columns of an image with `inputs` rows: computes row `k` of the result.
  void down(const Image<std::complex<float>>& in, int k, std::complex<float>* out) const;

  /// Factor from the Fourier sum of the values, with positions relative to their middle, to that of
  /// the samples relative to theirs. `cpp`: frequency, cycles per sample.
  std::complex<float> gain(double cpp) const;

 private:
  int inputs_;
  int bin_;
  std::vector<float> taps_;  ///< an odd number, symmetric
  int outputs_;
};

}  // namespace ovws::twin
