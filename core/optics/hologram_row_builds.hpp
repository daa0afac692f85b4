/// Declarations shared by the SIMD builds of hologram_row.hpp's kernels.
#pragma once

#include "core/optics/hologram_row.hpp"

namespace ovws {

extern const HologramRowKernels kPlainRow, kAvx2Row, kAvx512Row;

/// Rounding offset: half of 1/65536 wave, where 2^64 is one wave. The top 16 bits are then rounded.
constexpr std::uint64_t kHalfOfAStep = std::uint64_t{1} << 47;

/// Scalar HologramRowKernels::greys for the pixels from `from` on.
inline void greys_one_by_one(const std::uint16_t* base, const std::uint16_t* added,
                             const std::uint8_t* lut, int from, int count, std::uint8_t* grey) {
  for (int x = from; x < count; ++x) {
    grey[x] = lut[static_cast<std::uint16_t>(base[x] + added[x]) >> 8];
  }
}

}  // namespace ovws
