#include "core/base/image.hpp"

#include <array>
#include <utility>

namespace ovws {
namespace {

struct FormatRow {
  PixelFormat format;
  std::string_view name;
  int bits;
};
constexpr std::array<FormatRow, 5> kFormats{{{PixelFormat::mono8, "Mono8", 8},
                                             {PixelFormat::mono10, "Mono10", 10},
                                             {PixelFormat::mono12, "Mono12", 12},
                                             {PixelFormat::mono14, "Mono14", 14},
                                             {PixelFormat::mono16, "Mono16", 16}}};

const FormatRow& row_of(PixelFormat format) {
  return kFormats[std::size_t(format)];
}

}  // namespace

int significant_bits(PixelFormat format) {
  return row_of(format).bits;
}
int bytes_per_pixel(PixelFormat format) {
  return format == PixelFormat::mono8 ? 1 : 2;
}
std::string_view pixel_format_name(PixelFormat format) {
  return row_of(format).name;
}

std::optional<PixelFormat> pixel_format_from_name(std::string_view name) {
  for (const auto& row : kFormats) {
    if (row.name == name) return row.format;
  }
  return std::nullopt;
}

ImageView view_of(const Image<std::uint8_t>& image) {
  return {reinterpret_cast<const std::byte*>(image.pixels.data()), image.width, image.height,
          image.width, PixelFormat::mono8};
}

ImageView view_of(const Image<std::uint16_t>& image, PixelFormat format) {
  return {reinterpret_cast<const std::byte*>(image.pixels.data()), image.width, image.height,
          std::ptrdiff_t(image.width) * 2, format};
}

}  // namespace ovws
