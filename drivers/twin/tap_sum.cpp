#include "drivers/twin/tap_sum.hpp"

#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "drivers/twin/tap_sum.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::twin::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

/// Scalar version for CPUs without vectors.
std::complex<float> TapSum(const std::complex<float>* first, std::ptrdiff_t stride,
                           const float* along_x, const float* along_y) {
  std::complex<float> sum = 0.0F;
  for (int r = 0; r < kTapsAcross; ++r) {
    for (int c = 0; c < kTapsAcross; ++c) sum += along_y[r] * along_x[c] * first[r * stride + c];
  }
  return sum;
}

#else

std::complex<float> TapSum(const std::complex<float>* first, std::ptrdiff_t stride,
                           const float* along_x, const float* along_y) {
  // Vectors of real and imaginary parts by turns: a real weight multiplies them alike.
  using Floats = hn::CappedTag<float, 8>;
  const Floats f;
  constexpr int kLanes = int(hn::MaxLanes(Floats())), kVectors = 2 * kTapsAcross / kLanes;
  std::array<hn::Vec<Floats>, kVectors> sums;
#pragma GCC unroll 6  // keeps the sums in registers
  for (int v = 0; v < kVectors; ++v) sums[v] = hn::Zero(f);
  for (int r = 0; r < kTapsAcross; ++r) {
    const auto* const row = reinterpret_cast<const float*>(first + r * stride);
    const auto weight = hn::Set(f, along_y[r]);
#pragma GCC unroll 6
    for (int v = 0; v < kVectors; ++v) {
      sums[v] = hn::MulAdd(hn::LoadU(f, row + v * kLanes), weight, sums[v]);
    }
  }
  auto sum = hn::Zero(f);
#pragma GCC unroll 6
  for (int v = 0; v < kVectors; ++v) {
    const hn::Half<Floats> half;
    const auto weights = hn::LoadU(half, along_x + v * kLanes / 2);
    const auto twice = hn::Combine(f, hn::InterleaveUpper(half, weights, weights),
                                   hn::InterleaveLower(half, weights, weights));
    sum = hn::MulAdd(sums[v], twice, sum);
  }
  std::array<float, kLanes> parts;
  hn::StoreU(sum, f, parts.data());
  std::complex<float> total = 0.0F;
  for (std::size_t k = 0; k < parts.size(); k += 2)
    total += std::complex<float>(parts[k], parts[k + 1]);
  return total;
}

#endif

}  // namespace
}  // namespace ovws::twin::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws::twin {

HWY_EXPORT(TapSum);

std::complex<float> tap_sum(const std::complex<float>* first, std::ptrdiff_t stride,
                            const float* along_x, const float* along_y) {
  return HWY_DYNAMIC_DISPATCH(TapSum)(first, stride, along_x, along_y);
}

}  // namespace ovws::twin

#endif  // HWY_ONCE
