#include "core/pipeline/msb_alignment.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>

namespace ovws {
namespace {

constexpr int kPixelsPerFrame = 1 << 18;  // pixels examined per frame: some ten microseconds
constexpr int kFullPasses = 2;            // passes over all rows before only one row per frame
constexpr int kBlock = 16;                // a constant trip count lets the compiler vectorise

/// Bitwise OR of all pixels of the row.
std::uint16_t bits_of(const std::uint16_t* __restrict row, int width) {
  std::array<std::uint16_t, kBlock> bits{};
  int x = 0;
  for (; x + kBlock <= width; x += kBlock) {
    for (int i = 0; i < kBlock; ++i) bits[i] = std::uint16_t(bits[i] | row[x + i]);
  }
  for (; x < width; ++x) bits[0] = std::uint16_t(bits[0] | row[x]);
  return std::accumulate(bits.begin(), bits.end(), std::uint16_t(0), std::bit_or<>());
}

}  // namespace

int MsbAlignmentDetector::shift_bits(const ImageView& image) OVWS_NONBLOCKING {
  const PixelFormatTraits& format = traits_of(image.format);
  if (format.layout != PixelLayout::words || format.bits == 16) return 0;
  if (image.format != format_) {
    reset();
    format_ = image.format;
  }
  if (shift_bits_) return *shift_bits_;
  std::uint16_t seen = 0;
  const int empty = 16 - format.bits;
  const bool first = rows_seen_ < kFullPasses * image.height;
  const int rows =
      first ? std::clamp(kPixelsPerFrame / std::max(1, image.width), 1, image.height) : 1;
  for (int k = 0; k < rows && (seen & ((1 << empty) - 1)) == 0; ++k) {
    seen = std::uint16_t(seen |
                         bits_of(image.row<std::uint16_t>(rows_seen_ % image.height), image.width));
    rows_seen_ =
        first ? rows_seen_ + 1 : kFullPasses * image.height + (rows_seen_ + 1) % image.height;
  }
  if ((seen & ((1 << empty) - 1)) != 0) {
    shift_bits_ = 0;
  } else if ((seen >> format.bits) != 0) {
    shift_bits_ = empty;
  }
  return shift_bits_.value_or(0);
}

}  // namespace ovws
