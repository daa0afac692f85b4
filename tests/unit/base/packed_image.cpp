#include "tests/unit/base/packed_image.hpp"

#include <algorithm>
#include <random>

namespace ovws::test {
namespace {

/// Position of bit k of pixel x within the bits of its row.
std::size_t bit_of(PixelLayout layout, std::size_t x, int k) {
  const auto bit = std::size_t(k);
  switch (layout) {
    case PixelLayout::bytes:
      return 8 * x + bit;
    case PixelLayout::words:
      return 16 * x + bit;
    case PixelLayout::p10:
      return 10 * x + bit;
    case PixelLayout::p12:
      return 12 * x + bit;
    case PixelLayout::packed10:
    case PixelLayout::packed12: {
      const int low_bits = layout == PixelLayout::packed10 ? 2 : 4;
      const std::size_t three = x / 2 * 24, odd = x % 2;
      if (k < low_bits) return three + 8 + 4 * odd + bit;
      return three + 16 * odd + bit - std::size_t(low_bits);
    }
  }
  return 0;
}

}  // namespace

std::vector<std::byte> pack(const Image<std::uint16_t>& picture, PixelFormat format,
                            std::size_t padding_bytes, int shift) {
  const PixelFormatTraits& traits = traits_of(format);
  const std::size_t stride = row_bytes(format, picture.width) + padding_bytes;
  std::vector<std::byte> bytes(stride * std::size_t(picture.height) - padding_bytes);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      for (int k = 0; k < traits.bits; ++k) {
        if ((picture.at(x, y) >> k & 1) == 0) continue;
        const std::size_t bit = bit_of(traits.layout, std::size_t(x), k) + std::size_t(shift);
        bytes[stride * std::size_t(y) + bit / 8] |= std::byte(1U << bit % 8);
      }
    }
  }
  return bytes;
}

ImageView packed_view(const std::vector<std::byte>& bytes, int width, int height,
                      PixelFormat format, std::size_t padding_bytes, int shift) {
  ImageView view{bytes.data(), width, height,
                 std::ptrdiff_t(row_bytes(format, width) + padding_bytes), format};
  view.left_justified_bits = shift;
  return view;
}

Image<std::uint16_t> random_image(int width, int height, PixelFormat format, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> any(0, int(full_scale_dn(format)));
  Image<std::uint16_t> picture(width, height);
  for (std::uint16_t& pixel : picture.pixels) pixel = std::uint16_t(any(random));
  return picture;
}

}  // namespace ovws::test
