/// Camera images: borrowed views of driver buffers, and owned row-major images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/pixel_format.hpp"

namespace ovws {

/// A borrowed view of camera pixels, row-major, stride in bytes. Valid while the frame that lends
/// the buffer is held. Read the pixels with core/base/pixels.hpp, which knows every format.
struct ImageView {
  const std::byte* data = nullptr;
  int width = 0;   ///< columns of the colour plane `plane`
  int height = 0;  ///< its rows
  std::ptrdiff_t stride_bytes = 0;
  PixelFormat format = PixelFormat::mono8;
  int left_justified_bits = 0;  ///< right shift for MSB-aligned 16-bit pixels
  ColourPlane plane{};          ///< which of the camera's pixels the view holds

  /// The first pixel of row y of the whole camera image as T, std::uint8_t or std::uint16_t. These
  /// are pixel values only if in_place(image), see core/base/pixels.hpp.
  template <class T>
  const T* row(int y) const {
    return reinterpret_cast<const T*>(data + y * stride_bytes);
  }
};

/// An owned row-major image.
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

/// A view of an owned 8-bit or 16-bit image, for code that reads camera pixels.
ImageView view_of(const Image<std::uint8_t>& image);
ImageView view_of(const Image<std::uint16_t>& image, PixelFormat format);

/// One colour plane of an image: as a view (no copy, RT-safe), and as a copy.
ImageView on_plane(const ImageView& image, const ColourPlane& plane);
Image<float> on_plane(const Image<float>& image, const ColourPlane& plane);

}  // namespace ovws
