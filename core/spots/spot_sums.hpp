/// SIMD pixel kernels of the spot fit, with run-time dispatch (Highway).
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/realtime.hpp"

namespace ovws {

/// Pixels in memory, rows `stride` pixels apart.
template <class T>
struct PixelRows {
  const T* first = nullptr;
  std::ptrdiff_t stride = 0;
};

/// Smallest `side` that bin_cells accepts: one vector of the widest CPU.
constexpr int kMinSide = 16;

/// Bins pixels: sums squares of `bin` x `bin` pixels (1 or 2), minus `offset` per pixel, into
/// `side` x `side` cells, row-major. Returns the brightest pixel. RT-safe.
std::uint16_t bin_cells(const PixelRows<std::uint8_t>& pixels, int side, int bin, float offset,
                        float* cells) OVWS_NONBLOCKING;
std::uint16_t bin_cells(const PixelRows<std::uint16_t>& pixels, int side, int bin, float offset,
                        float* cells) OVWS_NONBLOCKING;

/// Row stride of the templates in floats: `cells` rounded up to whole vectors. The padding must be
/// 0 in the templates, and readable in the pixel array.
constexpr int padded(int cells) {
  return (cells + kMinSide - 1) / kMinSide * kMinSide;
}

/// Dot products of template rows: sums[r] = rows[r] . cells, for `count` rows `length` (padded)
/// floats apart. Returns the sum of weights * cells^2. RT-safe.
float dot_rows(const float* rows, int count, const float* weights, const float* cells, int length,
               float* sums) OVWS_NONBLOCKING;

}  // namespace ovws
