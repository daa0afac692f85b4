/// SIMD unpacking of packed, Bayer and MSB-aligned pixels, with run-time dispatch.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

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

/// One SIMD build of the unpacking loops. All builds give identical results.
struct UnpackKernels {
  std::string_view name;
  /// Unpacking functions, indexed by PixelLayout, then by step - 1 (every or every second pixel).
  std::array<std::array<UnpackRow, 2>, 6> rows;
};

/// SIMD builds of the unpacking loops that this CPU can run, the fastest last.
std::span<const UnpackKernels> all_unpack_kernels();

/// Fastest unpacking loop for a layout. `step`: 1 unpacks every pixel, 2 every second pixel.
UnpackRow unpack_row(PixelLayout layout, int step);

}  // namespace ovws
