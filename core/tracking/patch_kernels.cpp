#include "core/tracking/patch_kernels.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/tracking/patch_kernels.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kPatchBlock>;
using Ints = hn::RebindToSigned<Floats>;
using Vector = hn::Vec<Floats>;

int lanes() {
  return int(hn::Lanes(Floats()));
}
float sum_of(Vector v) {
  return hn::GetLane(hn::SumOfLanes(Floats(), v));
}

/// Calls step(x) for every SIMD vector of a row. The last vector may overlap the previous vector.
template <class Step>
void each_vector(int columns, Step step) {
  const int last = columns - lanes();
  for (int x = 0; x < last; x += lanes()) step(x);
  step(last);
}

template <class Pixel>
float load(const PixelRect& from, float* out) {
  auto least = hn::Set(Ints(), std::numeric_limits<int>::max());
  const std::byte* row = from.first;
  for (int y = 0; y < from.rows; ++y, row += from.stride_bytes, out += from.columns) {
    const auto* const pixels = reinterpret_cast<const Pixel*>(row);
    each_vector(from.columns, [&](int x) {
      const auto v = hn::PromoteTo(Ints(), hn::LoadU(hn::Rebind<Pixel, Ints>(), pixels + x));
      hn::StoreU(hn::ConvertTo(Floats(), v), Floats(), out + x);
      least = hn::Min(least, v);
    });
  }
  return float(hn::GetLane(hn::MinOfLanes(Ints(), least)));
}
float Load8(const PixelRect& from, float* out) {
  return load<std::uint8_t>(from, out);
}
float Load16(const PixelRect& from, float* out) {
  return load<std::uint16_t>(from, out);
}

float Brightest(const FloatRect& of) {
  Vector most = hn::Zero(Floats());
  for (int y = 0; y < of.rows; ++y) {
    const float* const row = of.first + y * of.stride;
    each_vector(of.columns, [&](int x) { most = hn::Max(most, hn::LoadU(Floats(), row + x)); });
  }
  return hn::GetLane(hn::MaxOfLanes(Floats(), most));
}

Vector fourth_difference(const float* at) {
  const Floats f;
  const Vector even = hn::Add(hn::LoadU(f, at), hn::LoadU(f, at + 4));
  const Vector odd = hn::Add(hn::LoadU(f, at + 1), hn::LoadU(f, at + 3));
  const Vector middle = hn::MulAdd(hn::Set(f, 6.0F), hn::LoadU(f, at + 2), even);
  return hn::NegMulAdd(hn::Set(f, 4.0F), odd, middle);
}

float FourthDifferences(const FloatRect& of) {
  const Floats f;
  const int last = of.columns - 4 - lanes();
  // Number of lanes of the last vector that overlap the previous vector.
  const auto seen = hn::Set(f, float((lanes() - last % lanes()) % lanes()));
  const auto is_new = hn::Ge(hn::Iota(f, 0.0F), seen);
  Vector sum = hn::Zero(f);
  for (int y = 0; y < of.rows; ++y) {
    const float* const row = of.first + y * of.stride;
    for (int x = 0; x < last; x += lanes()) {
      const Vector d = fourth_difference(row + x);
      sum = hn::MulAdd(d, d, sum);
    }
    const Vector d = hn::IfThenElseZero(is_new, fourth_difference(row + last));
    sum = hn::MulAdd(d, d, sum);
  }
  return sum_of(sum);
}

float Axis(const GaussianAxis& from, float* g, float* dg, float* ddg) {
  const Floats f;
  HWY_ALIGN std::array<float, hn::MaxLanes(Floats())> powers{from.first};
  float ratio = from.ratio;  // from.ratio^n: the step between n lanes
  for (int n = 1; n < lanes(); n *= 2, ratio *= ratio) {
    for (int k = 0; k < n; ++k) powers[std::size_t(n + k)] = powers[std::size_t(k)] * ratio;
  }
  const Vector next = hn::Set(f, ratio), step = hn::Set(f, float(lanes()));
  Vector power = hn::Load(f, powers.data()), d = hn::Iota(f, from.begin), sum = hn::Zero(f);
  for (int k = 0; k < from.padded; k += lanes()) {
    const Vector weight = hn::Mul(hn::LoadU(f, from.table + k), power);
    const Vector first = hn::Mul(d, weight);
    hn::StoreU(weight, f, g + k);
    hn::StoreU(first, f, dg + k);
    hn::StoreU(hn::Mul(d, first), f, ddg + k);
    sum = hn::Add(sum, weight);
    power = hn::Mul(power, next);
    d = hn::Add(d, step);
  }
  return sum_of(sum);
}

WindowSums Window(const float* first, std::ptrdiff_t stride, const WindowAxis& across,
                  const WindowAxis& down) {
  const Floats f;
  Vector one = hn::Zero(f), x = one, y = one, xx = one, xy = one, yy = one;
  for (int b = 0; b < across.padded; b += lanes()) {
    Vector s0 = hn::Zero(f), s1 = s0, s2 = s0;
    const float* pixels = first + b;
    for (int k = 0; k < down.count; ++k, pixels += stride) {
      const Vector p = hn::LoadU(f, pixels);
      s0 = hn::MulAdd(hn::Set(f, down.g[k]), p, s0);
      s1 = hn::MulAdd(hn::Set(f, down.dg[k]), p, s1);
      s2 = hn::MulAdd(hn::Set(f, down.ddg[k]), p, s2);
    }
    const Vector g = hn::LoadU(f, across.g + b), dg = hn::LoadU(f, across.dg + b);
    one = hn::MulAdd(g, s0, one);
    x = hn::MulAdd(dg, s0, x);
    xx = hn::MulAdd(hn::LoadU(f, across.ddg + b), s0, xx);
    y = hn::MulAdd(g, s1, y);
    xy = hn::MulAdd(dg, s1, xy);
    yy = hn::MulAdd(g, s2, yy);
  }
  return {sum_of(one), sum_of(x), sum_of(y), sum_of(xx), sum_of(xy), sum_of(yy)};
}

}  // namespace
}  // namespace ovws::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ovws {

HWY_EXPORT(Load8);
HWY_EXPORT(Load16);
HWY_EXPORT(Brightest);
HWY_EXPORT(FourthDifferences);
HWY_EXPORT(Axis);
HWY_EXPORT(Window);

float load8(const PixelRect& from, float* out) {
  return HWY_DYNAMIC_DISPATCH(Load8)(from, out);
}

float load16(const PixelRect& from, float* out) {
  return HWY_DYNAMIC_DISPATCH(Load16)(from, out);
}

float brightest(const FloatRect& of) {
  return HWY_DYNAMIC_DISPATCH(Brightest)(of);
}

float fourth_differences(const FloatRect& of) {
  return HWY_DYNAMIC_DISPATCH(FourthDifferences)(of);
}

float gaussian_axis(const GaussianAxis& from, float* g, float* dg, float* ddg) {
  return HWY_DYNAMIC_DISPATCH(Axis)(from, g, dg, ddg);
}

WindowSums window_sums(const float* first, std::ptrdiff_t stride, const WindowAxis& across,
                       const WindowAxis& down) {
  return HWY_DYNAMIC_DISPATCH(Window)(first, stride, across, down);
}

}  // namespace ovws
#endif  // HWY_ONCE
