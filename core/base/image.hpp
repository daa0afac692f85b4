/// Images: camera pixels read in place, and the pictures this code makes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace ovws {

/// GenICam PFNC names, unpacked formats; 16-bit ones are little-endian and right-justified.
enum class PixelFormat : std::uint8_t { mono8, mono10, mono12, mono14, mono16 };

int significant_bits(PixelFormat format);                ///< 8, 10, 12, 14 or 16
int bytes_per_pixel(PixelFormat format);                 ///< 1 or 2
std::string_view pixel_format_name(PixelFormat format);  ///< "Mono8", …
std::optional<PixelFormat> pixel_format_from_name(std::string_view name);

/// Borrowed camera pixels, row-major, stride in bytes. Valid while the frame that lends them is
/// held.
struct ImageView {
  const std::byte* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride_bytes = 0;
  PixelFormat format = PixelFormat::mono8;

  /// The first pixel of row y as T, std::uint8_t or std::uint16_t according to
  /// bytes_per_pixel(format).
  template <class T>
  const T* row(int y) const {
    return reinterpret_cast<const T*>(data + y * stride_bytes);
  }
};

/// An owned row-major picture.
template <class T>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<T> pixels;

  Image() = default;
  Image(int w, int h, T value = T{}) : width(w), height(h), pixels(std::size_t(w) * h, value) {}
  T* row(int y) { return pixels.data() + std::size_t(y) * width; }
  const T* row(int y) const { return pixels.data() + std::size_t(y) * width; }
  T& at(int x, int y) { return row(y)[x]; }
  const T& at(int x, int y) const { return row(y)[x]; }
};

/// A view of an owned 8-bit or 16-bit picture, for the same code that reads camera pixels.
ImageView view_of(const Image<std::uint8_t>& image);
ImageView view_of(const Image<std::uint16_t>& image, PixelFormat format);

}  // namespace ovws
