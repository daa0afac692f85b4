/// Reads and writes grey PNG files, pixel for pixel: no gamma correction, no scaling.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws {

/// A grey PNG file of 16 bits a pixel and exactly width x height pixels. The size is checked before
/// memory is allocated. Errors: Errc::invalid, without a field: the file cannot be read, is damaged
/// or truncated, or has another format or size.
Result<Image<std::uint16_t>> read_grey16_png(const std::string& path, int width, int height);

/// The bytes of a PNG file that holds this 8-bit grey image. Errors: Errc::internal, without a
/// field: libpng refused.
Result<std::string> encode_grey8_png(const Image<std::uint8_t>& image);

}  // namespace ovws
