/// Detects MSB-aligned (left-justified) pixel data: some drivers fill 16-bit words from the top,
/// although the format's name means LSB-aligned data.
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"

namespace ovws {

/// Detects MSB-aligned pixel data. One object per camera stream; not thread-safe.
class MsbAlignmentDetector {
 public:
  /// Right shift that makes the pixels LSB-aligned; 0 until MSB alignment is detected. A pixel
  /// above the format's full scale shows MSB alignment, unless a pixel has a low bit set that
  /// MSB-aligned data leave empty. Until the alignment is certain, each call examines some rows in
  /// turn, and one row per frame after two passes over all rows. RT-safe.
  int shift_bits(const ImageView& image) OVWS_NONBLOCKING;

  /// Restarts the detection for another stream.
  void reset() OVWS_NONBLOCKING { *this = {}; }

 private:
  PixelFormat format_ = PixelFormat::mono8;
  std::optional<int> shift_bits_;
  int rows_seen_ = 0;
};

}  // namespace ovws
