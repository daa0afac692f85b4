/// Encoding of an image in the camera's pixel formats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/image.hpp"

namespace ovws::twin {

/// Frame size in bytes for width x height pixels of this format.
std::size_t frame_bytes(PixelFormat format, int width, int height);

/// Encodes A/D converter values of `bits` bits. The values fill the most significant bits of the
/// format, as in real cameras. With `left_justified` and a format of 16-bit words, the values fill
/// the most significant bits of the word (MSB-aligned).
std::vector<std::byte> packed(const Image<std::uint16_t>& dn, int bits, PixelFormat format,
                              bool left_justified);

/// Applies the Bayer filters: attenuates the pixels whose filter colour is not the laser's.
void filter_colours(Image<float>& photons, PixelFormat format, double wavelength_nm);

}  // namespace ovws::twin
