/// Reading camera pixels of any format: directly from the buffer where each pixel is a whole byte
/// or word, unpacked otherwise. Only the requested pixels are read.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"

namespace ovws {

/// Whether ImageView::row points to pixel values that need no unpacking: the image has whole bytes
/// or words, no colour plane and no shift.
inline bool in_place(const ImageView& image) {
  const PixelLayout layout = traits_of(image.format).layout;
  return image.plane.everything() && image.left_justified_bits == 0 &&
         (layout == PixelLayout::bytes || layout == PixelLayout::words);
}

/// Bytes per pixel of an in-place image, 1 or 2.
inline int bytes_in_place(const ImageView& image) {
  return traits_of(image.format).layout == PixelLayout::bytes ? 1 : 2;
}

/// Unpacks the pixels (x, y) to (x + count - 1, y) to LSB-aligned numbers. The pixels must lie
/// inside `image`. Reads no byte outside the camera's image. RT-safe.
void unpack(const ImageView& image, int x, int y, int count, std::uint16_t* out) OVWS_NONBLOCKING;

/// Maximum number of pixels that visit_rows unpacks at a time.
constexpr int kPixelRun = 256;

/// Calls `visit(x, y, pixels, count)` for the rows of a rectangle, top to bottom, left to right.
/// `pixels` points to `count` pixels from (x, y) on, as std::uint8_t or std::uint16_t. A call gets
/// a whole row if in_place(image), otherwise at most kPixelRun unpacked pixels. The rectangle must
/// lie inside the image. RT-safe if `visit` is RT-safe.
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
