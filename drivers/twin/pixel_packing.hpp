/// Encoding of an image in the camera's pixel formats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/image.hpp"

namespace ovws::twin {

/// Bytes of a frame of this size.
std::size_t frame_bytes(PixelFormat format, int width, int height);

/// Encodes A/D converter values of `bits` bits. They fill the most significant bits of the format,
/// as in real cameras, or with `left_justified` those of its 16-bit words (MSB-aligned).
std::vector<std::byte> packed(const Image<std::uint16_t>& dn, int bits, PixelFormat format,
                              bool left_justified);

/// Applies the Bayer filters: attenuates pixels under filters of another colour than the laser's.
void filter_colours(Image<float>& photons, PixelFormat format, double wavelength_nm);

}  // namespace ovws::twin
