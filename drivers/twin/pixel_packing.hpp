/// How the twin's camera puts a picture into a pixel format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/image.hpp"

namespace ovws::twin {

/// What a frame of this size takes.
std::size_t frame_bytes(PixelFormat format, int width, int height);

/// The converter's numbers of `bits` bits as the left-most of the format's, as cameras do; and if
/// `left_justified`, of the 16-bit words that hold them.
std::vector<std::byte> packed(const Image<std::uint16_t>& dn, int bits, PixelFormat format,
                              bool left_justified);

/// Leaves of the light under filters of another colour than the laser's what they let through.
void filter_colours(Image<float>& photons, PixelFormat format, double wavelength_nm);

}  // namespace ovws::twin
