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

/// Unpacks `count` pixels from pixel `from` on: all of them, or every second one. RT-safe.
using UnpackRow = void (*)(const PackedRow& row, int from, int count, std::uint16_t* out);

/// One SIMD build of the unpacking loops. All builds give identical results.
struct UnpackKernels {
  std::string_view name;
  /// By PixelLayout, then by step: every pixel, every second pixel.
  std::array<std::array<UnpackRow, 2>, 6> rows;
};

/// The builds that this CPU can run, the fastest last.
std::span<const UnpackKernels> all_unpack_kernels();

/// The fastest build's loop. `step`: 1 or 2.
UnpackRow unpack_row(PixelLayout layout, int step);

}  // namespace ovws
