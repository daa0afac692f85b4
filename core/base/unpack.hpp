/// Numbers out of rows of packed, filtered or left-justified pixels, for the CPU that is there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/base/pixel_format.hpp"

namespace ovws {

/// A row of pixels in memory. No byte beyond `bytes` is read.
struct PackedRow {
  const std::byte* first = nullptr;
  std::ptrdiff_t bytes = 0;
  int shift = 0;  ///< of 16-bit pixels, to the right
};

/// `count` pixels, from pixel `from` on every first or every second. RT-safe.
using UnpackRow = void (*)(const PackedRow& row, int from, int count, std::uint16_t* out);

/// One build of the loops. All builds give the same numbers.
struct UnpackKernels {
  std::string_view name;
  /// By PixelLayout, then every pixel and every second.
  std::array<std::array<UnpackRow, 2>, 6> rows;
};

/// Those that this CPU can run, the fastest last.
std::span<const UnpackKernels> all_unpack_kernels();

/// Of the fastest. `step`: 1 or 2.
UnpackRow unpack_row(PixelLayout layout, int step);

}  // namespace ovws
