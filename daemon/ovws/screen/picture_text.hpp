/// Grey images as characters, for terminals that show no images.
#pragma once

#include <string>

#include "core/base/image.hpp"

namespace ovws::screen {

enum class Shades {
  ascii,   ///< a row of characters for two rows of pixels, from " " for black to "@" for white
  blocks,  ///< UTF-8 half blocks in the 24 greys of a terminal with 256 colours
};

/// The image scaled down to `columns` characters, with its aspect ratio, as lines that end with a
/// newline. Each character cell shows the pixel that differs most from the image's median: spots
/// and lines of one pixel stay visible. Empty for an empty image.
std::string picture_text(const Image<std::uint8_t>& image, int columns, Shades shades);

}  // namespace ovws::screen
