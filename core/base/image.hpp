/// Images: camera pixels where the camera put them, and the pictures this code makes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/pixel_format.hpp"

namespace ovws {

/// Borrowed camera pixels, row-major, stride in bytes. Valid while the frame that lends them is
/// held. Read by core/base/pixels.hpp, which knows the formats.
struct ImageView {
  const std::byte* data = nullptr;
  int width = 0;   ///< of the lit pixels' lattice, if the view is of one
  int height = 0;  ///< the same
  std::ptrdiff_t stride_bytes = 0;
  PixelFormat format = PixelFormat::mono8;
  int left_justified_bits = 0;  ///< by which every 16-bit pixel is to be shifted right
  PixelLattice lattice{};       ///< which of the camera's pixels these are

  /// The first camera pixel of the camera's row y as T, std::uint8_t or std::uint16_t. Only for
  /// pixels that are in place, see there.
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

/// The pixels of a lattice alone, as an image of their own. RT-safe.
ImageView on_lattice(const ImageView& image, const PixelLattice& lattice);
Image<float> on_lattice(const Image<float>& image, const PixelLattice& lattice);

}  // namespace ovws
