#include "drivers/twin/pixel_packing.hpp"

#include <algorithm>

namespace ovws::twin {
namespace {

constexpr float kLeak = 0.03F;  // typical transmission of a Bayer filter outside its colour

/// Writes the low `count` bits of `value` from bit `first_bit` on, LSB first (PFNC "p" formats).
void put_bits(std::vector<std::byte>& bytes, std::size_t first_bit, int count, unsigned value) {
  for (int k = 0; k < count; ++k) {
    const std::size_t bit = first_bit + std::size_t(k);
    if ((value >> k & 1U) != 0) bytes[bit / 8] |= std::byte(1U << bit % 8);
  }
}

/// GigE Vision 1 packing of two pixels in three bytes. The first and the last byte hold the high
/// eight bits of one pixel each; the middle byte holds the low bits of the two pixels.
void put_packed_pair(std::vector<std::byte>& bytes, std::size_t pixel, int bits, unsigned value) {
  const std::size_t first = pixel / 2 * 3, odd = pixel % 2;
  bytes[first + 2 * odd] = std::byte(value >> (bits - 8));
  bytes[first + 1] |= std::byte((value & ((1U << (bits - 8)) - 1)) << (4 * odd));
}

}  // namespace

std::size_t frame_bytes(PixelFormat format, int width, int height) {
  const std::size_t bits = traits_of(format).code >> 16 & 0xFFU;  // bits per pixel in a PFNC code
  return (std::size_t(width) * std::size_t(height) * bits + 7) / 8;
}

std::vector<std::byte> packed(const Image<std::uint16_t>& dn, int bits, PixelFormat format,
                              bool left_justified) {
  const PixelFormatTraits& traits = traits_of(format);
  const bool words = traits.layout == PixelLayout::words;
  const int up = (left_justified && words ? 16 : traits.bits) - bits;
  std::vector<std::byte> bytes(frame_bytes(format, dn.width, dn.height));
  const auto each = [&](const auto& put) {
    // One of the shifts is by 0: a branch for each pixel would take longer.
    const int left = std::max(up, 0), right = std::max(-up, 0);
    for (std::size_t i = 0; i < dn.pixels.size(); ++i) {
      put(i, unsigned(dn.pixels[i]) << left >> right);
    }
  };
  switch (traits.layout) {
    case PixelLayout::bytes:
      each([&](std::size_t i, unsigned value) { bytes[i] = std::byte(value); });
      break;
    case PixelLayout::words:
      each([&](std::size_t i, unsigned value) {
        bytes[2 * i] = std::byte(value & 0xFFU);
        bytes[2 * i + 1] = std::byte(value >> 8);
      });
      break;
    case PixelLayout::p10:
    case PixelLayout::p12:
      each([&](std::size_t i, unsigned value) {
        put_bits(bytes, i * std::size_t(traits.bits), traits.bits, value);
      });
      break;
    case PixelLayout::packed10:
    case PixelLayout::packed12:
      each([&](std::size_t i, unsigned value) { put_packed_pair(bytes, i, traits.bits, value); });
      break;
  }
  return bytes;
}

void filter_colours(Image<float>& photons, PixelFormat format, double wavelength_nm) {
  const LitPixels lit = lit_pixels(format, wavelength_nm);
  if (lit.plane.everything()) return;
  const auto passes = [](const ColourPlane& plane, int x, int y) {
    return x % 2 == plane.x && y % 2 == plane.y;
  };
  for (int y = 0; y < photons.height; ++y) {
    for (int x = 0; x < photons.width; ++x) {
      const bool transmitted =
          passes(lit.plane, x, y) || (lit.diagonal && passes(lit.other(), x, y));
      if (!transmitted) photons.at(x, y) *= kLeak;
    }
  }
}

}  // namespace ovws::twin
