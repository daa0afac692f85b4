#include "core/base/unpack.hpp"

#ifdef __x86_64__
#include <immintrin.h>
#endif

#include <algorithm>

#include "core/base/runnable.hpp"

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

struct Plain {
  template <L kLayout, int kStep>
  static void row(const PackedRow& row, int from, int count, std::uint16_t* out) {
    for (std::ptrdiff_t i = 0; i < count; ++i) out[i] = pixel_at<kLayout>(row, from + i * kStep);
  }
};

#ifdef __x86_64__
#define OVWS_AVX2 __attribute__((target("avx2")))

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

struct Avx2 {
  template <L kLayout, int kStep>
  OVWS_AVX2 static void row(const PackedRow& row, int from, int count, std::uint16_t* out) {
    int i = 0;
    for (; i + 8 <= count && readable<kLayout, kStep>(row, from + i * kStep); i += 8) {
      put<kLayout, kStep>(row, from + i * kStep, out + i);
    }
    const int last = count - 8;  // the last block may overlap the previous one
    if (i < count && last >= 0 && readable<kLayout, kStep>(row, from + last * kStep)) {
      return put<kLayout, kStep>(row, from + last * kStep, out + last);
    }
    for (; i < count; ++i) out[i] = pixel_at<kLayout>(row, from + std::ptrdiff_t(i) * kStep);
  }

 private:
  template <L kLayout>
  static std::ptrdiff_t first_byte(std::ptrdiff_t x) {
    if constexpr (kLayout == L::bytes) return x;
    if constexpr (kLayout == L::words) return 2 * x;
    if constexpr (is_p(kLayout)) return bits_of(kLayout) * x / 8;
    return x / 2 * 3;
  }

  template <L kLayout, int kStep>
  static bool readable(const PackedRow& row, std::ptrdiff_t x) {
    constexpr int kRead = kLayout == L::bytes ? 8 : 16;
    return first_byte<kLayout>(x + 8 * (kStep - 1)) + kRead <= row.bytes;
  }

  template <L kLayout>
  OVWS_AVX2 static __m128i eight(const PackedRow& row, std::ptrdiff_t x) {
    const auto* from = reinterpret_cast<const __m128i*>(row.first + first_byte<kLayout>(x));
    if constexpr (kLayout == L::bytes) {
      return _mm_cvtepu8_epi16(_mm_loadl_epi64(from));
    } else if constexpr (kLayout == L::words) {
      return _mm_srl_epi16(_mm_loadu_si128(from), _mm_cvtsi32_si128(row.shift));
    } else {
      static constexpr std::array<Recipe, 4> kRecipes{recipe<kLayout>(0), recipe<kLayout>(1),
                                                      recipe<kLayout>(2), recipe<kLayout>(3)};
      constexpr int kBits = bits_of(kLayout), kPhases = kLayout == L::p10 ? 4 : 2;
      const Recipe& r = kRecipes[std::size_t(x % kPhases)];
      const auto pick = _mm_load_si128(reinterpret_cast<const __m128i*>(r.pick.data()));
      const auto up = _mm_load_si128(reinterpret_cast<const __m128i*>(r.up.data()));
      const __m128i words = _mm_shuffle_epi8(_mm_loadu_si128(from), pick);
      const __m128i moved = _mm_mullo_epi16(words, up);
      if constexpr (is_p(kLayout)) return _mm_srli_epi16(moved, 16 - kBits);
      const __m128i low = _mm_set1_epi16((1 << (kBits - 8)) - 1);
      return _mm_or_si128(_mm_slli_epi16(_mm_srli_epi16(words, 8), kBits - 8),
                          _mm_and_si128(_mm_srli_epi16(moved, 4), low));
    }
  }

  template <L kLayout, int kStep>
  OVWS_AVX2 static void put(const PackedRow& row, std::ptrdiff_t x, std::uint16_t* out) {
    __m128i pixels = eight<kLayout>(row, x);
    if constexpr (kStep == 2) {
      const __m128i even = _mm_set1_epi32(0xFFFF);
      pixels = _mm_packus_epi32(_mm_and_si128(pixels, even),
                                _mm_and_si128(eight<kLayout>(row, x + 8), even));
    }
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), pixels);
  }
};
#endif

template <class Build, L kLayout>
constexpr std::array<UnpackRow, 2> both_steps() {
  return {Build::template row<kLayout, 1>, Build::template row<kLayout, 2>};
}

template <class Build>
constexpr UnpackKernels kernels(std::string_view name) {
  return {name,
          {both_steps<Build, L::bytes>(), both_steps<Build, L::words>(),
           both_steps<Build, L::p10>(), both_steps<Build, L::p12>(),
           both_steps<Build, L::packed10>(), both_steps<Build, L::packed12>()}};
}

#ifdef __x86_64__
constexpr std::array kAll{kernels<Plain>("plain"), kernels<Avx2>("avx2")};
#else
constexpr std::array kAll{kernels<Plain>("plain")};
#endif

}  // namespace

std::span<const UnpackKernels> all_unpack_kernels() {
  return std::span(kAll).first(std::min(kAll.size(), runnable_builds()));
}

UnpackRow unpack_row(PixelLayout layout, int step) {
  static const UnpackKernels& fastest = all_unpack_kernels().back();
  return fastest.rows[std::size_t(layout)][std::size_t(step - 1)];
}

}  // namespace ovws
