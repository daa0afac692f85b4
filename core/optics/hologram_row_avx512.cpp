/// Hologram row kernels for AVX-512 with byte permutations (VBMI).
#ifdef __x86_64__
#include <immintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "core/optics/hologram_row_builds.hpp"

#define OVWS_TARGET __attribute__((target("avx512f,avx512bw,avx512vbmi")))
#define OVWS_LANES 8

namespace ovws {
namespace {

using Fixed = std::uint64_t __attribute__((vector_size(64)));

OVWS_TARGET inline void put_words(const Fixed& a0, const Fixed& b0, const Fixed& a1,
                                  const Fixed& b1, std::uint16_t* out) {
  alignas(64) static constexpr std::array<std::uint16_t, 32> kTopWords{
      3, 7, 11, 15, 19, 23, 27, 31, 35, 39, 43, 47, 51, 55, 59, 63,
      3, 7, 11, 15, 19, 23, 27, 31, 35, 39, 43, 47, 51, 55, 59, 63};
  const __m512i top = _mm512_load_si512(kTopWords.data());
  const __m512i first =
      _mm512_permutex2var_epi16(reinterpret_cast<__m512i>(a0), top, reinterpret_cast<__m512i>(b0));
  const __m512i second =
      _mm512_permutex2var_epi16(reinterpret_cast<__m512i>(a1), top, reinterpret_cast<__m512i>(b1));
  _mm512_storeu_si512(out, _mm512_mask_blend_epi64(0xF0, first, second));
}
OVWS_TARGET void greys(const std::uint16_t* base, const std::uint16_t* added,
                       const std::uint8_t* lut, int count, std::uint8_t* grey) {
  if (count < 64) return greys_one_by_one(base, added, lut, 0, count, grey);
  const __m512i lut0 = _mm512_loadu_si512(lut), lut1 = _mm512_loadu_si512(lut + 64);
  const __m512i lut2 = _mm512_loadu_si512(lut + 128), lut3 = _mm512_loadu_si512(lut + 192);
  alignas(64) std::array<std::uint8_t, 64> high_bytes;
  for (int i = 0; i < 64; ++i) high_bytes[i] = static_cast<std::uint8_t>(2 * i + 1);
  const __m512i high = _mm512_load_si512(high_bytes.data());
  for (int x = 0; x < count; x += 64) {
    x = std::min(x, count - 64);  // the last block overlaps the previous one
    const __m512i first =
        _mm512_add_epi16(_mm512_loadu_si512(base + x), _mm512_loadu_si512(added + x));
    const __m512i second =
        _mm512_add_epi16(_mm512_loadu_si512(base + x + 32), _mm512_loadu_si512(added + x + 32));
    const __m512i steps = _mm512_permutex2var_epi8(first, high, second);
    const __m512i below = _mm512_permutex2var_epi8(lut0, steps, lut1);
    const __m512i above = _mm512_permutex2var_epi8(lut2, steps, lut3);
    _mm512_storeu_si512(grey + x, _mm512_mask_blend_epi8(_mm512_movepi8_mask(steps), below, above));
  }
}

#include "core/optics/hologram_row.inc"

}  // namespace

const HologramRowKernels kAvx512Row{"avx512vbmi", phases, greys};

}  // namespace ovws
#endif
