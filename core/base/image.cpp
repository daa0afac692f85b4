#include "core/base/image.hpp"

namespace ovws {

ImageView view_of(const Image<std::uint8_t>& image) {
  return {reinterpret_cast<const std::byte*>(image.pixels.data()), image.width, image.height,
          image.width, PixelFormat::mono8};
}

ImageView view_of(const Image<std::uint16_t>& image, PixelFormat format) {
  return {reinterpret_cast<const std::byte*>(image.pixels.data()), image.width, image.height,
          std::ptrdiff_t(image.width) * 2, format};
}

ImageView on_plane(const ImageView& image, const ColourPlane& plane) {
  ImageView view = image;
  view.width = plane.count(image.width, plane.x);
  view.height = plane.count(image.height, plane.y);
  view.plane = plane;
  return view;
}

Image<float> on_plane(const Image<float>& image, const ColourPlane& plane) {
  Image<float> out(plane.count(image.width, plane.x), plane.count(image.height, plane.y));
  for (int y = 0; y < out.height; ++y) {
    const float* const from = image.row(plane.y + y * plane.step);
    for (int x = 0; x < out.width; ++x) out.at(x, y) = from[plane.x + x * plane.step];
  }
  return out;
}

}  // namespace ovws
