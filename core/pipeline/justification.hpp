/// Where in their 16 bits a camera puts its numbers: some drivers fill them from the left, whatever
/// the format's name says.
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"

namespace ovws {

/// For one stream. One thread.
class Justification {
 public:
  /// Bits by which the pixels are to be shifted right: 0 until a pixel is above the format's full
  /// scale while none had any of the low bits that left-justified numbers leave empty. Looks at
  /// some rows of each frame, others each time, until it knows; at one row a frame once it has seen
  /// all rows twice. RT-safe.
  int bits_to_shift(const ImageView& image) OVWS_NONBLOCKING;

  /// Another stream begins.
  void forget() OVWS_NONBLOCKING { *this = {}; }

 private:
  PixelFormat format_ = PixelFormat::mono8;
  std::optional<int> known_bits_;
  int rows_seen_ = 0;
};

}  // namespace ovws
