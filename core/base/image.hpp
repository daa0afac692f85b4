/// Camera images: borrowed views of driver buffers, and owned row-major images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/pixel_format.hpp"

namespace ovws {

/// View of camera pixels in a borrowed buffer, row-major, stride in bytes. Valid until the frame
/// that lends the buffer is released. To read pixels of any format, use core/base/pixels.hpp.
struct ImageView {
  const std::byte* data = nullptr;
  int width = 0;   ///< columns of the colour plane `plane`
  int height = 0;  ///< rows of the colour plane `plane`
  std::ptrdiff_t stride_bytes = 0;
  PixelFormat format = PixelFormat::mono8;
  int left_justified_bits = 0;  ///< right shift for MSB-aligned 16-bit pixels
  ColourPlane plane{};          ///< colour plane to read; by default all camera pixels

  /// Pointer to the first pixel of row y of the whole camera image. T: std::uint8_t or
  /// std::uint16_t. The data are pixel values only if in_place(image), see core/base/pixels.hpp.
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

/// One colour plane of an image. The first overload returns a view (no copy, RT-safe), the second
/// a copy.
ImageView on_plane(const ImageView& image, const ColourPlane& plane);
Image<float> on_plane(const Image<float>& image, const ColourPlane& plane);

}  // namespace ovws
