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

ImageView on_lattice(const ImageView& image, const PixelLattice& lattice) {
  ImageView view = image;
  view.width = lattice.count(image.width, lattice.x);
  view.height = lattice.count(image.height, lattice.y);
  view.lattice = lattice;
  return view;
}

Image<float> on_lattice(const Image<float>& image, const PixelLattice& lattice) {
  Image<float> out(lattice.count(image.width, lattice.x), lattice.count(image.height, lattice.y));
  for (int y = 0; y < out.height; ++y) {
    const float* const from = image.row(lattice.y + y * lattice.step);
    for (int x = 0; x < out.width; ++x) out.at(x, y) = from[lattice.x + x * lattice.step];
  }
  return out;
}

}  // namespace ovws
