/// Hologram row kernels for any CPU: SSE2 on x86-64, scalar elsewhere.
#ifdef __x86_64__
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "core/optics/hologram_row_builds.hpp"

#define OVWS_TARGET
#define OVWS_LANES 2

namespace ovws {
namespace {

using Fixed = std::uint64_t __attribute__((vector_size(16)));

#ifdef __x86_64__
/// High 32 bits of each 64-bit lane of two registers.
inline __m128i high_halves(const Fixed& a, const Fixed& b) {
  return _mm_castps_si128(
      _mm_shuffle_ps(reinterpret_cast<__m128>(a), reinterpret_cast<__m128>(b), 0xDD));
}
inline void put_words(const Fixed& a0, const Fixed& b0, const Fixed& a1, const Fixed& b1,
                      std::uint16_t* out) {
  // The arithmetic shift keeps values in 16-bit range, so the saturating pack changes nothing.
  const __m128i words = _mm_packs_epi32(_mm_srai_epi32(high_halves(a0, b0), 16),
                                        _mm_srai_epi32(high_halves(a1, b1), 16));
  _mm_storel_epi64(reinterpret_cast<__m128i*>(out), words);
  _mm_storeh_pd(reinterpret_cast<double*>(out + kPhaseLanes), _mm_castsi128_pd(words));
}
void greys(const std::uint16_t* base, const std::uint16_t* added, const std::uint8_t* lut,
           int count, std::uint8_t* grey) {
  int x = 0;
  for (; x + 8 <= count; x += 8) {
    const __m128i phase =
        _mm_add_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(base + x)),
                      _mm_loadu_si128(reinterpret_cast<const __m128i*>(added + x)));
    const __m128i steps = _mm_srli_epi16(phase, 8);
    auto eight = static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm_packus_epi16(steps, steps)));
#pragma GCC unroll 8
    for (int i = 0; i < 8; ++i, eight >>= 8) grey[x + i] = lut[eight & 0xFF];
  }
  greys_one_by_one(base, added, lut, x, count, grey);
}
#else
inline void put_words(const Fixed& a0, const Fixed& b0, const Fixed& a1, const Fixed& b1,
                      std::uint16_t* out) {
  for (int i = 0; i < OVWS_LANES; ++i) {
    out[i] = static_cast<std::uint16_t>(a0[i] >> 48);
    out[OVWS_LANES + i] = static_cast<std::uint16_t>(b0[i] >> 48);
    out[kPhaseLanes + i] = static_cast<std::uint16_t>(a1[i] >> 48);
    out[kPhaseLanes + OVWS_LANES + i] = static_cast<std::uint16_t>(b1[i] >> 48);
  }
}
void greys(const std::uint16_t* base, const std::uint16_t* added, const std::uint8_t* lut,
           int count, std::uint8_t* grey) {
  greys_one_by_one(base, added, lut, 0, count, grey);
}
#endif

#include "core/optics/hologram_row.inc"

}  // namespace

const HologramRowKernels kPlainRow{"plain", phases, greys};

}  // namespace ovws
