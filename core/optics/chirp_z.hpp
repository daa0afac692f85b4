/// Chirp-z transform of many lines: Fourier sums at any equally spaced frequencies.
#pragma once

#include <complex>
#include <memory>

namespace ovws {

/// Sampling of one axis: number of input samples, and the output frequencies first + k step in
/// cycles per sample.
struct ChirpAxis {
  int inputs = 0;
  int outputs = 0;
  double first = 0.0;
  double step = 0.0;
};

/// Chirp-z transform (Bluestein, IEEE Trans. Audio 18, 451, 1970) by two FFTs a line, in single
/// precision with chirps computed in double. For one thread at a time.
class ChirpZ {
 public:
  explicit ChirpZ(const ChirpAxis& axis);
  ~ChirpZ();
  ChirpZ(ChirpZ&&) noexcept;
  ChirpZ& operator=(ChirpZ&&) noexcept;

  /// out[k stride + line] = sum over x of in[x] exp(-2 pi i (first + k step) (x - centre)), where
  /// centre = (axis.inputs - 1) / 2. `in`: `lines` rows of axis.inputs values.
  void transform(const std::complex<float>* in, int lines, std::complex<float>* out, int stride);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
