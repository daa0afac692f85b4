/// Packs images into every pixel format, bit by bit after the formats' definitions.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/image.hpp"

namespace ovws::test {

/// Packs pixels of at most significant_bits(format), with `padding_bytes` after each row. 16-bit
/// pixels are shifted left by `shift` (MSB-aligned data).
std::vector<std::byte> pack(const Image<std::uint16_t>& picture, PixelFormat format,
                            std::size_t padding_bytes = 0, int shift = 0);

/// A view of a packed image.
ImageView packed_view(const std::vector<std::byte>& bytes, int width, int height,
                      PixelFormat format, std::size_t padding_bytes = 0, int shift = 0);

/// Uniformly distributed pixels over the format's range; the same seed gives the same image.
Image<std::uint16_t> random_image(int width, int height, PixelFormat format, unsigned seed);

/// Name of a case of a suite of pixel formats.
inline std::string format_name(const testing::TestParamInfo<PixelFormat>& of) {
  return std::string(pixel_format_name(of.param));
}

}  // namespace ovws::test
