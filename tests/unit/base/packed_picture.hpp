/// Pictures in every pixel format, put there bit by bit as the formats' definitions say.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/image.hpp"

namespace ovws::test {

/// Numbers of at most significant_bits(format). Rows have `padding_bytes` after them. 16-bit ones
/// are moved up by `shift`.
std::vector<std::byte> pack(const Image<std::uint16_t>& picture, PixelFormat format,
                            std::size_t padding_bytes = 0, int shift = 0);

/// A view of what `pack` made.
ImageView packed_view(const std::vector<std::byte>& bytes, int width, int height,
                      PixelFormat format, std::size_t padding_bytes = 0, int shift = 0);

/// The same for the same seed: every number that the format can hold is as likely.
Image<std::uint16_t> random_picture(int width, int height, PixelFormat format, unsigned seed);

}  // namespace ovws::test
