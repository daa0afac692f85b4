/// Chirp-z transform (Bluestein): the Fourier sum of lines at any equally spaced frequencies.
#pragma once

#include <complex>
#include <memory>

namespace ovws {

/// out[k] = sum over x of in[x] exp(-2 pi i (first + k step) (x - centre)), by two FFTs a line and
/// one in the constructor; four lines at a time, one in each SIMD lane. Single precision, with
/// chirps computed in double. Movable; `transform` is for one thread at a time.
class ChirpZ {
 public:
  struct Axis {
    int inputs = 0;
    int outputs = 0;
    double centre = 0.0;
    double first = 0.0;  ///< cycles per sample
    double step = 0.0;
  };

  explicit ChirpZ(const Axis& axis);
  ~ChirpZ();
  ChirpZ(ChirpZ&&) noexcept;
  ChirpZ& operator=(ChirpZ&&) noexcept;
  ChirpZ(const ChirpZ&) = delete;
  ChirpZ& operator=(const ChirpZ&) = delete;

  /// `in`: `lines` rows of axis.inputs values. `out`: the transposed result, axis.outputs rows of
  /// `lines` values.
  void transform(const std::complex<float>* in, int lines, std::complex<float>* out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
