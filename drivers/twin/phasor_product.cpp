#include "drivers/twin/phasor_product.hpp"

#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "drivers/twin/phasor_product.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::twin::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float kPi = std::numbers::pi_v<float>;

/// Taylor series in x^2 with these coefficients, from the highest power down.
template <class F, std::size_t kCount>
hn::Vec<F> Series(F f, hn::Vec<F> square, const float (&coefficients)[kCount]) {
  auto sum = hn::Set(f, coefficients[0]);
  for (std::size_t k = 1; k < kCount; ++k) {
    sum = hn::MulAdd(sum, square, hn::Set(f, coefficients[k]));
  }
  return sum;
}

template <class F>
void MultiplyLanes(F f, const float* waves, float* values) {
  constexpr float kSine[] = {-1.0F / 39916800, 1.0F / 362880, -1.0F / 5040,
                             1.0F / 120,       -1.0F / 6,     1.0F};
  constexpr float kCosine[] = {1.0F / 479001600, -1.0F / 3628800, 1.0F / 40320, -1.0F / 720,
                               1.0F / 24,        -0.5F,           1.0F};
  const auto turns = hn::LoadU(f, waves);
  // Half of the angle lies within a quarter of a turn, where the series converge fast.
  const auto half = hn::Mul(hn::Sub(turns, hn::Round(turns)), hn::Set(f, kPi));
  const auto square = hn::Mul(half, half);
  const auto sine = hn::Mul(half, Series(f, square, kSine)), cosine = Series(f, square, kCosine);
  const auto twice = hn::Add(sine, sine);
  const auto re = hn::NegMulAdd(twice, sine, hn::Set(f, 1.0F)), im = hn::Mul(twice, cosine);
  hn::Vec<F> value_re, value_im;
  hn::LoadInterleaved2(f, values, value_re, value_im);
  hn::StoreInterleaved2(hn::MulSub(value_re, re, hn::Mul(value_im, im)),
                        hn::MulAdd(value_re, im, hn::Mul(value_im, re)), f, values);
}

void MultiplyByPhasors(const float* waves, int count, float* values) {
  const hn::ScalableTag<float> f;
  const hn::CappedTag<float, 1> one;
  const int lanes = int(hn::Lanes(f));
  int k = 0;
  for (; k + lanes <= count; k += lanes) MultiplyLanes(f, waves + k, values + 2 * k);
  for (; k < count; ++k) MultiplyLanes(one, waves + k, values + 2 * k);
}

}  // namespace
}  // namespace ovws::twin::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws::twin {

HWY_EXPORT(MultiplyByPhasors);

void multiply_by_phasors(const float* waves, int count, std::complex<float>* values) {
  // A complex number is its real and its imaginary part, one after the other.
  HWY_DYNAMIC_DISPATCH(MultiplyByPhasors)(waves, count, reinterpret_cast<float*>(values));
}

}  // namespace ovws::twin

#endif  // HWY_ONCE
