/// Conversion of X server images to colours.
#pragma once

#include <X11/Xlib.h>

#include <cstdint>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws::sdl {

/// 0xRRGGBB of each pixel, for any byte order. Errc::unavailable, field "slm.display", if the image
/// does not have 8 bits each of red, green and blue in this order (a screen of 16 or 30 bits).
Result<Image<std::uint32_t>> colours_of(XImage& image);

}  // namespace ovws::sdl
