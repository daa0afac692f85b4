#include "core/spots/spot_sums.hpp"

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/spots/spot_sums.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kMinSide>;
using Ints = hn::RebindToSigned<Floats>;
using Words = hn::RebindToUnsigned<Floats>;  // 32 bit

#if HWY_TARGET == HWY_SCALAR

/// Scalar binning for CPUs without vectors.
template <class T>
std::uint16_t bin_any(const PixelRows<T>& pixels, int side, int bin, float offset, float* cells) {
  int most = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      int sum = 0;
      for (int k = 0; k < bin * bin; ++k) {
        const int v = pixels.first[(bin * y + k / bin) * pixels.stride + bin * x + k % bin];
        sum += v;
        most = std::max(most, v);
      }
      *cells++ = float(sum) - float(bin * bin) * offset;
    }
  }
  return std::uint16_t(most);
}

#else

/// Loads pixels and sums neighbouring pairs, for one vector of binned pixels.
template <class T>
struct Pairs {
  using Pixels = hn::Repartition<std::uint16_t, Words>;
  using Vector = hn::Vec<Pixels>;

  static Vector load(const std::uint16_t* at) { return hn::LoadU(Pixels(), at); }
  static Vector load(const std::uint8_t* at) {
    return hn::PromoteTo(Pixels(), hn::LoadU(hn::Rebind<std::uint8_t, Pixels>(), at));
  }
  static hn::Vec<Words> sums(Vector v) {
    const auto both = hn::BitCast(Words(), v);
    return hn::Add(hn::And(both, hn::Set(Words(), 0xFFFFU)), hn::ShiftRight<16>(both));
  }
};

template <class D, class V>
std::uint16_t largest(D tag, V v) {
  HWY_ALIGN std::array<hn::TFromD<D>, hn::MaxLanes(D())> lanes{};
  hn::Store(v, tag, lanes.data());
  return std::uint16_t(*std::max_element(lanes.begin(), lanes.begin() + hn::Lanes(tag)));
}

/// Calls `cell` for each vector of a row; the last vector may overlap the previous one.
template <class Cell>
void each_vector(int side, Cell cell) {
  const int step = int(hn::Lanes(Floats()));
  for (int x = 0; x < side; x += step) cell(std::min(x, side - step));
}

template <class T>
std::uint16_t bin_pairs(const PixelRows<T>& pixels, int side, float offset, float* cells) {
  using P = Pairs<T>;
  auto most = hn::Zero(typename P::Pixels());
  const auto minus = hn::Set(Floats(), -4.0F * offset);
  for (int y = 0; y < side; ++y, cells += side) {
    const T* const upper = pixels.first + 2 * y * pixels.stride;
    const T* const lower = upper + pixels.stride;
    each_vector(side, [&](int x) {
      const auto a = P::load(upper + 2 * x), b = P::load(lower + 2 * x);
      most = hn::Max(most, hn::Max(a, b));
      const auto sum = hn::BitCast(Ints(), hn::Add(P::sums(a), P::sums(b)));
      hn::StoreU(hn::Add(hn::ConvertTo(Floats(), sum), minus), Floats(), cells + x);
    });
  }
  return largest(typename P::Pixels(), most);
}

template <class T>
std::uint16_t copy_pixels(const PixelRows<T>& pixels, int side, float offset, float* cells) {
  auto most = hn::Zero(Ints());
  const auto minus = hn::Set(Floats(), -offset);
  for (int y = 0; y < side; ++y, cells += side) {
    const T* const row = pixels.first + y * pixels.stride;
    each_vector(side, [&](int x) {
      const auto v = hn::PromoteTo(Ints(), hn::LoadU(hn::Rebind<T, Ints>(), row + x));
      most = hn::Max(most, v);
      hn::StoreU(hn::Add(hn::ConvertTo(Floats(), v), minus), Floats(), cells + x);
    });
  }
  return largest(Ints(), most);
}

template <class T>
std::uint16_t bin_any(const PixelRows<T>& pixels, int side, int bin, float offset, float* cells) {
  return bin == 2 ? bin_pairs(pixels, side, offset, cells)
                  : copy_pixels(pixels, side, offset, cells);
}

#endif

std::uint16_t Bin8(const PixelRows<std::uint8_t>& pixels, int side, int bin, float offset,
                   float* cells) {
  return bin_any(pixels, side, bin, offset, cells);
}
std::uint16_t Bin16(const PixelRows<std::uint16_t>& pixels, int side, int bin, float offset,
                    float* cells) {
  return bin_any(pixels, side, bin, offset, cells);
}

/// Dot product of one row.
void dot(const float* row, const float* cells, int length, float* sum) {
  const Floats f;
  auto total = hn::Zero(f);
  for (int c = 0; c < length; c += int(hn::Lanes(f))) {
    total = hn::MulAdd(hn::LoadU(f, row + c), hn::LoadU(f, cells + c), total);
  }
  *sum = hn::GetLane(hn::SumOfLanes(f, total));
}

/// Dot products of four rows, so that the pixels are loaded only once. Written out, because the
/// compiler keeps an array of sums in memory, which takes twice as long.
void dot_four(const float* rows, const float* cells, int length, float* sums) {
  const Floats f;
  const auto at = [&](int row, int c) {
    return hn::LoadU(f, rows + std::ptrdiff_t(row) * length + c);
  };
  auto sum0 = hn::Zero(f), sum1 = sum0, sum2 = sum0, sum3 = sum0;
  for (int c = 0; c < length; c += int(hn::Lanes(f))) {
    const auto v = hn::LoadU(f, cells + c);
    sum0 = hn::MulAdd(at(0, c), v, sum0);
    sum1 = hn::MulAdd(at(1, c), v, sum1);
    sum2 = hn::MulAdd(at(2, c), v, sum2);
    sum3 = hn::MulAdd(at(3, c), v, sum3);
  }
  sums[0] = hn::GetLane(hn::SumOfLanes(f, sum0));
  sums[1] = hn::GetLane(hn::SumOfLanes(f, sum1));
  sums[2] = hn::GetLane(hn::SumOfLanes(f, sum2));
  sums[3] = hn::GetLane(hn::SumOfLanes(f, sum3));
}

float Dots(const float* rows, int count, const float* weights, const float* cells, int length,
           float* sums) {
  int r = 0;
  for (; r + 4 <= count; r += 4)
    dot_four(rows + std::ptrdiff_t(r) * length, cells, length, sums + r);
  for (; r < count; ++r) dot(rows + std::ptrdiff_t(r) * length, cells, length, sums + r);
  const Floats f;
  auto squares = hn::Zero(f);
  for (int c = 0; c < length; c += int(hn::Lanes(f))) {
    const auto v = hn::LoadU(f, cells + c);
    squares = hn::MulAdd(hn::Mul(v, v), hn::LoadU(f, weights + c), squares);
  }
  return hn::GetLane(hn::SumOfLanes(f, squares));
}

}  // namespace
}  // namespace ovws::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ovws {

HWY_EXPORT(Bin8);
HWY_EXPORT(Bin16);
HWY_EXPORT(Dots);

std::uint16_t bin_cells(const PixelRows<std::uint8_t>& pixels, int side, int bin, float offset,
                        float* cells) {
  return HWY_DYNAMIC_DISPATCH(Bin8)(pixels, side, bin, offset, cells);
}

std::uint16_t bin_cells(const PixelRows<std::uint16_t>& pixels, int side, int bin, float offset,
                        float* cells) {
  return HWY_DYNAMIC_DISPATCH(Bin16)(pixels, side, bin, offset, cells);
}

float dot_rows(const float* rows, int count, const float* weights, const float* cells, int length,
               float* sums) {
  return HWY_DYNAMIC_DISPATCH(Dots)(rows, count, weights, cells, length, sums);
}

}  // namespace ovws
#endif  // HWY_ONCE
