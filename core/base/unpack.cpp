#include "core/base/unpack.hpp"

#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/base/unpack.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#ifndef OVWS_UNPACK_SCALAR
#define OVWS_UNPACK_SCALAR
namespace ovws {
namespace {

using L = PixelLayout;

constexpr bool is_p(L layout) {
  return layout == L::p10 || layout == L::p12;
}
constexpr int bits_of(L layout) {
  return layout == L::p10 || layout == L::packed10 ? 10 : 12;
}

/// Scalar unpacking of one pixel.
template <L kLayout>
std::uint16_t pixel_at(const PackedRow& row, std::ptrdiff_t x) {
  const auto byte = [&](std::ptrdiff_t at) { return std::to_integer<unsigned>(row.first[at]); };
  constexpr int kBits = bits_of(kLayout);
  if constexpr (kLayout == L::bytes) {
    return std::uint16_t(byte(x));
  } else if constexpr (kLayout == L::words) {
    return std::uint16_t((byte(2 * x) | byte(2 * x + 1) << 8) >> row.shift);
  } else if constexpr (is_p(kLayout)) {
    const std::ptrdiff_t bit = kBits * x;  // each pixel spans exactly two bytes
    const unsigned word = byte(bit / 8) | byte(bit / 8 + 1) << 8;
    return std::uint16_t(word >> (bit % 8) & ((1U << kBits) - 1));
  } else {
    constexpr int kLow = kBits - 8;
    const std::ptrdiff_t three = x / 2 * 3, odd = x % 2;
    const unsigned low = byte(three + 1) >> (4 * odd) & ((1U << kLow) - 1);
    return std::uint16_t(byte(three + 2 * odd) << kLow | low);
  }
}

template <L kLayout, int kStep>
void plain_row(const PackedRow& row, int from, int count, std::uint16_t* out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) out[i] = pixel_at<kLayout>(row, from + i * kStep);
}

/// Byte shuffle and shifts that extract eight adjacent packed pixels from 16 bytes. `pick` selects
/// the two bytes of each pixel. Multiplying by `up` shifts left. p10, p12: drops the next
/// pixel's bits; packed10, packed12: aligns the pixel's low bits, and a mask drops the other's.
struct Recipe {
  alignas(16) std::array<std::uint8_t, 16> pick{};
  alignas(16) std::array<std::uint16_t, 8> up{};
};

/// Recipe for eight pixels, the first of which is pixel `phase` of a group that fills whole bytes.
template <L kLayout>
constexpr Recipe recipe(int phase) {
  Recipe r;
  constexpr int kBits = bits_of(kLayout);
  for (int i = 0; i < 8; ++i) {
    int low = 0, high = 0, up = 0;
    if (is_p(kLayout)) {
      const int bit = kBits * (phase + i) - kBits * phase / 8 * 8;
      low = bit / 8, high = low + 1, up = 16 - kBits - bit % 8;
    } else {
      const int three = (phase + i) / 2 * 3, odd = (phase + i) % 2;
      low = three + 1, high = three + 2 * odd, up = odd ? 0 : 4;
    }
    r.pick[std::size_t(2 * i)] = std::uint8_t(low);
    r.pick[std::size_t(2 * i + 1)] = std::uint8_t(high);
    r.up[std::size_t(i)] = std::uint16_t(1U << up);
  }
  return r;
}

}  // namespace
}  // namespace ovws
#endif

HWY_BEFORE_NAMESPACE();
namespace ovws::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

template <L kLayout, int kStep>
constexpr UnpackRow kRow = plain_row<kLayout, kStep>;

#else

namespace hn = hwy::HWY_NAMESPACE;

using Words = hn::FixedTag<std::uint16_t, 8>;
using Bytes = hn::FixedTag<std::uint8_t, 16>;
using Vector = hn::Vec<Words>;

template <L kLayout>
constexpr std::ptrdiff_t first_byte(std::ptrdiff_t x) {
  if constexpr (kLayout == L::bytes) return x;
  if constexpr (kLayout == L::words) return 2 * x;
  if constexpr (is_p(kLayout)) return bits_of(kLayout) * x / 8;
  return x / 2 * 3;
}

template <L kLayout, int kStep>
bool readable(const PackedRow& row, std::ptrdiff_t x) {
  constexpr int kRead = kLayout == L::bytes ? 8 : 16;
  return first_byte<kLayout>(x + 8 * (kStep - 1)) + kRead <= row.bytes;
}

/// Eight adjacent pixels.
template <L kLayout>
Vector eight(const PackedRow& row, std::ptrdiff_t x) {
  const auto* from = reinterpret_cast<const std::uint8_t*>(row.first + first_byte<kLayout>(x));
  if constexpr (kLayout == L::bytes) {
    return hn::PromoteTo(Words(), hn::LoadU(hn::Rebind<std::uint8_t, Words>(), from));
  } else if constexpr (kLayout == L::words) {
    return hn::ShiftRightSame(hn::BitCast(Words(), hn::LoadU(Bytes(), from)), row.shift);
  } else {
    static constexpr std::array<Recipe, 4> kRecipes{recipe<kLayout>(0), recipe<kLayout>(1),
                                                    recipe<kLayout>(2), recipe<kLayout>(3)};
    constexpr int kBits = bits_of(kLayout), kPhases = kLayout == L::p10 ? 4 : 2;
    const Recipe& r = kRecipes[std::size_t(x % kPhases)];
    const auto pick = hn::Load(Bytes(), r.pick.data());
    const Vector words = hn::BitCast(Words(), hn::TableLookupBytes(hn::LoadU(Bytes(), from), pick));
    const Vector moved = hn::Mul(words, hn::Load(Words(), r.up.data()));
    if constexpr (is_p(kLayout)) return hn::ShiftRight<16 - kBits>(moved);
    const Vector low = hn::Set(Words(), (1 << (kBits - 8)) - 1);
    return hn::Or(hn::ShiftLeft<kBits - 8>(hn::ShiftRight<8>(words)),
                  hn::And(hn::ShiftRight<4>(moved), low));
  }
}

template <L kLayout, int kStep>
void put(const PackedRow& row, std::ptrdiff_t x, std::uint16_t* out) {
  Vector pixels = eight<kLayout>(row, x);
  if constexpr (kStep == 2) pixels = hn::ConcatEven(Words(), eight<kLayout>(row, x + 8), pixels);
  hn::StoreU(pixels, Words(), out);
}

template <L kLayout, int kStep>
void row(const PackedRow& row, int from, int count, std::uint16_t* out) {
  int i = 0;
  for (; i + 8 <= count && readable<kLayout, kStep>(row, from + i * kStep); i += 8) {
    put<kLayout, kStep>(row, from + i * kStep, out + i);
  }
  const int last = count - 8;  // the last block may overlap the previous one
  if (i < count && last >= 0 && readable<kLayout, kStep>(row, from + last * kStep)) {
    return put<kLayout, kStep>(row, from + last * kStep, out + last);
  }
  plain_row<kLayout, kStep>(row, from + i * kStep, count - i, out + i);
}

template <L kLayout, int kStep>
constexpr UnpackRow kRow = row<kLayout, kStep>;

#endif

UnpackRow Choose(PixelLayout layout, int step) {
  static constexpr std::array<std::array<UnpackRow, 2>, 6> kRows{
      {{kRow<L::bytes, 1>, kRow<L::bytes, 2>},
       {kRow<L::words, 1>, kRow<L::words, 2>},
       {kRow<L::p10, 1>, kRow<L::p10, 2>},
       {kRow<L::p12, 1>, kRow<L::p12, 2>},
       {kRow<L::packed10, 1>, kRow<L::packed10, 2>},
       {kRow<L::packed12, 1>, kRow<L::packed12, 2>}}};
  return kRows[std::size_t(layout)][std::size_t(step - 1)];
}

}  // namespace
}  // namespace ovws::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ovws {

HWY_EXPORT(Choose);

UnpackRow unpack_row(PixelLayout layout, int step) {
  return HWY_DYNAMIC_DISPATCH(Choose)(layout, step);
}

}  // namespace ovws
#endif  // HWY_ONCE
