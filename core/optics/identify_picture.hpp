/// Identification image: shows a person which screen is the SLM and how it is oriented.
#pragma once

#include <cstdint>

#include "core/base/image.hpp"

namespace ovws {

/// Fills an image of any size with a frame, "OVWS" upright, and arrows towards +x and +y. White on
/// black, without the LUT.
void draw_identify_picture(Image<std::uint8_t>& grey);

}  // namespace ovws
