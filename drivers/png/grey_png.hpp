/// Greyscale PNG files, read and written pixel for pixel: no gamma correction, no scaling.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws {

/// Reads a 16-bit greyscale PNG file of exactly width x height pixels. The size is checked before
/// memory is allocated. Errors: Errc::invalid without a field if the file cannot be read, is
/// damaged or truncated, or has another format or size; Errc::internal if libpng fails.
Result<Image<std::uint16_t>> read_grey16_png(const std::string& path, int width, int height);
/// Reads a 16-bit greyscale PNG file of any size up to `max_side` pixels along each side. Errors:
/// as above.
Result<Image<std::uint16_t>> read_grey16_png(const std::string& path, int max_side);

/// Encodes an 8-bit greyscale image as PNG. Errors: Errc::internal without a field if libpng fails.
Result<std::string> encode_grey8_png(const Image<std::uint8_t>& image);

}  // namespace ovws
