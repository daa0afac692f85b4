/// The picture by which a person finds out which screen is the SLM, and which way it is turned.
#pragma once

#include <cstdint>

#include "core/base/image.hpp"

namespace ovws {

/// Fills the image, whatever its size: a frame, "OVWS" upright, an arrow towards +x and one towards
/// +y. White on black, not through any LUT.
void draw_identify_picture(Image<std::uint8_t>& grey);

}  // namespace ovws
