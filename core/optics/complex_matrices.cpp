#include "core/optics/complex_matrices.hpp"

#include <algorithm>
#include <array>
#include <cassert>

#include "core/base/complex_product.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/optics/complex_matrices.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 2 * kMinProductRows>;

#if HWY_TARGET == HWY_SCALAR

/// Scalar version for CPUs without vectors.
void Multiply(const ComplexColumns& a, const ComplexColumns& b, std::complex<float>* out,
              int stride) {
  for (int n = 0; n < b.rows; ++n) {
    for (int m = 0; m < a.rows; ++m) {
      std::complex<float> sum = 0.0F;
      for (int k = 0; k < a.columns; ++k) {
        sum += a.first[m + k * a.stride] * b.first[n + k * b.stride];
      }
      out[m + n * stride] = sum;
    }
  }
}

void MultiplyEach(const std::complex<float>* a, const std::complex<float>* b, int count,
                  std::complex<float>* out) {
  for (int k = 0; k < count; ++k) out[k] = product(a[k], b[k]);
}

#else

using Vector = hn::Vec<Floats>;

/// Computes one vector of rows, from row `m` on, of kColumns columns of the product, from column
/// `n` on. A vector holds real and imaginary parts by turns.
template <int kColumns>
void MultiplyBlock(const ComplexColumns& a, const ComplexColumns& b, int m, int n,
                   std::complex<float>* out, int stride) {
  std::array<Vector, kColumns> by_real, by_imaginary;
#pragma GCC unroll 4  // keeps the sums in registers
  for (int c = 0; c < kColumns; ++c) by_real[c] = by_imaginary[c] = hn::Zero(Floats());
  for (int k = 0; k < a.columns; ++k) {
    const auto* const rows = reinterpret_cast<const float*>(a.first + m + k * a.stride);
    const std::complex<float>* const factors = b.first + n + k * b.stride;
    const Vector left = hn::LoadU(Floats(), rows);
#pragma GCC unroll 4
    for (int c = 0; c < kColumns; ++c) {
      by_real[c] = hn::MulAdd(left, hn::Set(Floats(), factors[c].real()), by_real[c]);
      by_imaginary[c] = hn::MulAdd(left, hn::Set(Floats(), factors[c].imag()), by_imaginary[c]);
    }
  }
#pragma GCC unroll 4
  for (int c = 0; c < kColumns; ++c) {
    const Vector swapped = hn::Shuffle2301(by_imaginary[c]);
    const Vector product = hn::OddEven(hn::Add(by_real[c], swapped), hn::Sub(by_real[c], swapped));
    hn::StoreU(product, Floats(), reinterpret_cast<float*>(out + m + (n + c) * stride));
  }
}

void Multiply(const ComplexColumns& a, const ComplexColumns& b, std::complex<float>* out,
              int stride) {
  constexpr int kColumns = 4;
  const int step = int(hn::Lanes(Floats())) / 2;
  for (int m = 0; m < a.rows; m += step) {
    const int row = std::min(m, a.rows - step);  // the last vector may overlap the previous one
    int n = 0;
    for (; n + kColumns <= b.rows; n += kColumns)
      MultiplyBlock<kColumns>(a, b, row, n, out, stride);
    for (; n < b.rows; ++n) MultiplyBlock<1>(a, b, row, n, out, stride);
  }
}

void MultiplyEach(const std::complex<float>* a, const std::complex<float>* b, int count,
                  std::complex<float>* out) {
  const Floats f;
  const int step = int(hn::Lanes(f)) / 2;
  const auto numbers = [](const std::complex<float>* of) {
    return reinterpret_cast<const float*>(of);
  };
  int k = 0;
  for (; k + step <= count; k += step) {
    const Vector left = hn::LoadU(f, numbers(a + k)), right = hn::LoadU(f, numbers(b + k));
    const Vector by_real = hn::Mul(left, hn::DupEven(right));
    const Vector by_imaginary = hn::Mul(hn::Shuffle2301(left), hn::DupOdd(right));
    const Vector both = hn::OddEven(hn::Add(by_real, by_imaginary), hn::Sub(by_real, by_imaginary));
    hn::StoreU(both, f, reinterpret_cast<float*>(out + k));
  }
  for (; k < count; ++k) out[k] = product(a[k], b[k]);
}

#endif

}  // namespace
}  // namespace ovws::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws {
namespace {

HWY_EXPORT(Multiply);
HWY_EXPORT(MultiplyEach);

ComplexColumns columns_of(const Eigen::Ref<const Eigen::MatrixXcf>& matrix) {
  return {matrix.data(), int(matrix.rows()), int(matrix.cols()), int(matrix.outerStride())};
}

}  // namespace

void multiply_by_transposed(const Eigen::Ref<const Eigen::MatrixXcf>& a,
                            const Eigen::Ref<const Eigen::MatrixXcf>& b,
                            Eigen::Ref<Eigen::MatrixXcf> out) {
  assert(a.rows() >= kMinProductRows && a.cols() == b.cols());
  assert(out.rows() == a.rows() && out.cols() == b.rows());
  HWY_DYNAMIC_DISPATCH(Multiply)
  (columns_of(a), columns_of(b), out.data(), int(out.outerStride()));
}

void multiply_each(const std::complex<float>* a, const std::complex<float>* b, int count,
                   std::complex<float>* out) {
  HWY_DYNAMIC_DISPATCH(MultiplyEach)(a, b, count, out);
}

}  // namespace ovws

#endif
