/// Chirp-z transform of many lines: Fourier sums at any equally spaced frequencies.
#pragma once

#include <complex>
#include <memory>
#include <span>

namespace ovws {

/// Sampling of one axis: number of input samples, and the output frequencies first + k step in
/// cycles per sample.
struct ChirpAxis {
  int inputs = 0;
  int outputs = 0;
  double first = 0.0;
  double step = 0.0;
};

/// FFT length >= `at_least`: a multiple of 16 without factors above 5, for which FFTW has fast
/// code.
int fast_fft_length(int at_least);

/// Chirp-z transform (Bluestein, IEEE Trans. Audio 18, 451, 1970) by two FFTs a line, in single
/// precision with chirps computed in double. If 1 / step is a fast FFT length that is not shorter
/// than inputs and outputs, one FFT of this length is enough. For one thread at a time.
class ChirpZ {
 public:
  /// `gains`: factors on the outputs, axis.outputs of them; empty: 1.
  explicit ChirpZ(const ChirpAxis& axis, std::span<const float> gains = {});
  ~ChirpZ();
  ChirpZ(ChirpZ&&) noexcept;
  ChirpZ& operator=(ChirpZ&&) noexcept;

  /// out[k stride + line] = sum over x of in[x] exp(-2 pi i (first + k step) (x - centre)), where
  /// centre = (axis.inputs - 1) / 2. `in`: `lines` rows of axis.inputs values.
  void transform(const std::complex<float>* in, int lines, std::complex<float>* out, int stride);
  /// The same without transposition: out[line axis.outputs + k].
  void transform_in_order(const std::complex<float>* in, int lines, std::complex<float>* out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
