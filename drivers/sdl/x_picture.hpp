/// What the X server gives of its screen, as colours.
#pragma once

#include <X11/Xlib.h>

#include <cstdint>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws::sdl {

/// 0xRRGGBB of each pixel, whatever the order of the bytes. Errors (Errc::unavailable, field
/// "slm.display"): its colours have not 8 bits each, or lie in another order (a screen of 30 or 16
/// bits).
Result<Image<std::uint32_t>> colours_of(XImage& image);

}  // namespace ovws::sdl
