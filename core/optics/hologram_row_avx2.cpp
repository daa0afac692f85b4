/// Hologram row kernels for AVX2.
#ifdef __x86_64__
#include <immintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "core/optics/hologram_row_builds.hpp"

#define OVWS_TARGET __attribute__((target("avx2")))
#define OVWS_LANES 4

namespace ovws {
namespace {

using Fixed = std::uint64_t __attribute__((vector_size(32)));

OVWS_TARGET inline __m256i high_halves(const Fixed& a, const Fixed& b) {
  return _mm256_castps_si256(
      _mm256_shuffle_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b), 0xDD));
}
OVWS_TARGET inline void put_words(const Fixed& a0, const Fixed& b0, const Fixed& a1,
                                  const Fixed& b1, std::uint16_t* out) {
  const __m256i words = _mm256_packs_epi32(_mm256_srai_epi32(high_halves(a0, b0), 16),
                                           _mm256_srai_epi32(high_halves(a1, b1), 16));
  // Reorders pairs of lanes: a b a' b' in each half become a a b b and a' a' b' b'.
  const __m256i sorted =
      _mm256_permutevar8x32_epi32(words, _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm256_castsi256_si128(sorted));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(out + kPhaseLanes),
                   _mm256_extracti128_si256(sorted, 1));
}

/// The LUT for pshufb look-up: 2 halves of 8 rows of 16 levels, each row duplicated in both 128-bit
/// lanes. Rows after the first of a half are stored XORed with the previous row (XOR delta coding).
struct LutRows {
  __m256i low[8], high[8];
};
OVWS_TARGET inline __m256i lut_row(const std::uint8_t* lut, int row) {
  return _mm256_broadcastsi128_si256(
      _mm_loadu_si128(reinterpret_cast<const __m128i*>(lut + 16 * row)));
}
OVWS_TARGET inline void fill(LutRows& rows, const std::uint8_t* lut) {
  for (int i = 0; i < 8; ++i) {
    rows.low[i] = lut_row(lut, i);
    rows.high[i] = lut_row(lut, 8 + i);
    if (i == 0) continue;
    rows.low[i] = _mm256_xor_si256(rows.low[i], lut_row(lut, i - 1));
    rows.high[i] = _mm256_xor_si256(rows.high[i], lut_row(lut, 7 + i));
  }
}
OVWS_TARGET inline __m256i look_up(const LutRows& rows, const __m256i& steps) {
  // In iteration i, steps below 16 i have wrapped to 128 or more, for which the shuffle gives 0.
  const __m256i row_length = _mm256_set1_epi8(16);
  __m256i at = _mm256_and_si256(steps, _mm256_set1_epi8(0x7F));
  __m256i low = _mm256_shuffle_epi8(rows.low[0], at);
  __m256i high = _mm256_shuffle_epi8(rows.high[0], at);
#pragma GCC unroll 8
  for (int i = 1; i < 8; ++i) {
    at = _mm256_sub_epi8(at, row_length);
    low = _mm256_xor_si256(low, _mm256_shuffle_epi8(rows.low[i], at));
    high = _mm256_xor_si256(high, _mm256_shuffle_epi8(rows.high[i], at));
    // Keeps this order: a compiler that combines all iterations last runs out of registers.
    __asm__("" : "+x"(at), "+x"(low), "+x"(high));
  }
  return _mm256_blendv_epi8(low, high, steps);
}
OVWS_TARGET inline __m256i steps_at(const std::uint16_t* base, const std::uint16_t* added) {
  const auto* b = reinterpret_cast<const __m256i*>(base);
  const auto* a = reinterpret_cast<const __m256i*>(added);
  const __m256i first = _mm256_add_epi16(_mm256_loadu_si256(b), _mm256_loadu_si256(a));
  const __m256i second = _mm256_add_epi16(_mm256_loadu_si256(b + 1), _mm256_loadu_si256(a + 1));
  return _mm256_permute4x64_epi64(
      _mm256_packus_epi16(_mm256_srli_epi16(first, 8), _mm256_srli_epi16(second, 8)), 0xD8);
}
OVWS_TARGET void greys(const std::uint16_t* base, const std::uint16_t* added,
                       const std::uint8_t* lut, int count, std::uint8_t* grey) {
  if (count < 32) return greys_one_by_one(base, added, lut, 0, count, grey);
  LutRows rows;
  fill(rows, lut);
  for (int x = 0; x < count; x += 32) {
    x = std::min(x, count - 32);  // the last block overlaps the previous one
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(grey + x),
                        look_up(rows, steps_at(base + x, added + x)));
  }
}

#include "core/optics/hologram_row.inc"

}  // namespace

const HologramRowKernels kAvx2Row{"avx2", phases, greys};

}  // namespace ovws
#endif
