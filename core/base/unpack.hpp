/// SIMD unpacking of packed, Bayer and MSB-aligned pixels, with run-time dispatch (Highway).
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/pixel_format.hpp"

namespace ovws {

/// A row of camera pixels in memory. No byte beyond `bytes` is read.
struct PackedRow {
  const std::byte* first = nullptr;
  std::ptrdiff_t bytes = 0;
  int shift = 0;  ///< right shift for MSB-aligned 16-bit pixels
};

/// Unpacks `count` pixels into `out`, starting at pixel `from`: adjacent pixels, or every second
/// pixel of the row. RT-safe.
using UnpackRow = void (*)(const PackedRow& row, int from, int count, std::uint16_t* out);

/// Unpacking loop for a layout, for this CPU. `step`: 1 unpacks every pixel, 2 every second pixel.
UnpackRow unpack_row(PixelLayout layout, int step);

}  // namespace ovws
