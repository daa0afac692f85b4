#include "drivers/twin/complex_sums.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "drivers/twin/complex_sums.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::twin::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, kSplitLanes>;
using Vector = hn::Vec<Floats>;

/// kRows rows of a vector's width: their sums stay in registers.
template <int kRows>
void AddColumns(const std::complex<float>* a, int depth, const SplitRows& b, const SplitRows& sum) {
  const Floats f;
  Vector re[kRows], im[kRows];
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
    re[r] = hn::LoadU(f, sum.re + r * sum.stride);
    im[r] = hn::LoadU(f, sum.im + r * sum.stride);
  }
  for (int k = 0; k < depth; ++k) {
    const auto b_re = hn::LoadU(f, b.re + k * b.stride), b_im = hn::LoadU(f, b.im + k * b.stride);
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) {
      const auto a_re = hn::Set(f, a[r * depth + k].real());
      const auto a_im = hn::Set(f, a[r * depth + k].imag());
      re[r] = hn::NegMulAdd(a_im, b_im, hn::MulAdd(a_re, b_re, re[r]));
      im[r] = hn::MulAdd(a_im, b_re, hn::MulAdd(a_re, b_im, im[r]));
    }
  }
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
    hn::StoreU(re[r], f, sum.re + r * sum.stride);
    hn::StoreU(im[r], f, sum.im + r * sum.stride);
  }
}

void AddProduct(const std::complex<float>* a, int rows, int depth, const SplitRows& b, int width,
                const SplitRows& sum) {
  constexpr int kRows = 4;
  const int lanes = int(hn::Lanes(Floats()));
  for (int x = 0; x < width; x += lanes) {
    const SplitRows columns{b.re + x, b.im + x, b.stride};
    int r = 0;
    for (; r < rows; r += r + kRows <= rows ? kRows : 1) {
      const SplitRows out{sum.re + x + r * sum.stride, sum.im + x + r * sum.stride, sum.stride};
      if (r + kRows <= rows) {
        AddColumns<kRows>(a + r * depth, depth, columns, out);
      } else {
        AddColumns<1>(a + r * depth, depth, columns, out);
      }
    }
  }
}

}  // namespace
}  // namespace ovws::twin::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws::twin {

HWY_EXPORT(AddProduct);

void add_product(const std::complex<float>* a, int rows, int depth, const SplitRows& b, int width,
                 const SplitRows& sum) {
  HWY_DYNAMIC_DISPATCH(AddProduct)(a, rows, depth, b, width, sum);
}

}  // namespace ovws::twin

#endif  // HWY_ONCE
