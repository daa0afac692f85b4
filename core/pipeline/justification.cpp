#include "core/pipeline/justification.hpp"

#include <algorithm>

namespace ovws {
namespace {

constexpr int kPixelsPerFrame = 32768;

/// All bits that any pixel of the row has.
std::uint16_t bits_of(const std::uint16_t* row, int width) {
  std::uint16_t bits = 0;
  for (int x = 0; x < width; ++x) bits = std::uint16_t(bits | row[x]);
  return bits;
}

}  // namespace

int Justification::bits_to_shift(const ImageView& image) OVWS_NONBLOCKING {
  const PixelFormatTraits& format = traits_of(image.format);
  if (format.layout != PixelLayout::words || format.bits == 16) return 0;
  if (image.format != format_) {
    forget();
    format_ = image.format;
  }
  if (known_bits_) return *known_bits_;
  std::uint16_t seen = 0;
  const int rows = std::clamp(kPixelsPerFrame / std::max(1, image.width), 1, image.height);
  for (int k = 0; k < rows; ++k) {
    next_row_ = (next_row_ + 1) % image.height;
    seen = std::uint16_t(seen | bits_of(image.row<std::uint16_t>(next_row_), image.width));
  }
  const int empty = 16 - format.bits;
  if ((seen & ((1 << empty) - 1)) != 0) {
    known_bits_ = 0;
  } else if ((seen >> format.bits) != 0) {
    known_bits_ = empty;
  }
  return known_bits_.value_or(0);
}

}  // namespace ovws
