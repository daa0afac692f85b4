/// Reading camera pixels, whatever their format: where they lie if each is a whole byte or word of
/// its own, unpacked otherwise, and only those that are asked for.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"

namespace ovws {

/// Whether ImageView::row reads them: neighbours in memory, and nothing to shift.
inline bool in_place(const ImageView& image) {
  const PixelLayout layout = traits_of(image.format).layout;
  return image.lattice.everything() && image.left_justified_bits == 0 &&
         (layout == PixelLayout::bytes || layout == PixelLayout::words);
}

/// Bytes of a pixel that is in place, 1 or 2.
inline int bytes_in_place(const ImageView& image) {
  return traits_of(image.format).layout == PixelLayout::bytes ? 1 : 2;
}

/// Pixels (x, y) to (x + count - 1, y), all of them inside the image, as numbers in the low bits.
/// No byte outside the camera's own pixels is read. RT-safe.
void unpack(const ImageView& image, int x, int y, int count, std::uint16_t* out) OVWS_NONBLOCKING;

/// Pixels that visit_rows hands out at most at once, of those that are not in place.
constexpr int kPixelRun = 256;

/// Calls `visit(x, y, pixels, count)` for the rectangle's rows from the top down, from left to
/// right: `count` pixels from (x, y) on, a whole row if they are in place, runs of kPixelRun
/// otherwise; `pixels` points to std::uint8_t or std::uint16_t. The rectangle must lie inside the
/// image. RT-safe if `visit` is.
template <class Visit>
void visit_rows(const ImageView& image, int left, int top, int columns, int rows, Visit visit) {
  if (in_place(image)) {
    const bool bytes = bytes_in_place(image) == 1;
    for (int y = top; y < top + rows; ++y) {
      if (bytes) {
        visit(left, y, image.row<std::uint8_t>(y) + left, columns);
      } else {
        visit(left, y, image.row<std::uint16_t>(y) + left, columns);
      }
    }
    return;
  }
  std::array<std::uint16_t, kPixelRun> run;
  for (int y = top; y < top + rows; ++y) {
    for (int x = left; x < left + columns; x += kPixelRun) {
      const int count = std::min(kPixelRun, left + columns - x);
      unpack(image, x, y, count, run.data());
      visit(x, y, static_cast<const std::uint16_t*>(run.data()), count);
    }
  }
}

}  // namespace ovws
