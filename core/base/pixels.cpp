#include "core/base/pixels.hpp"

#include "core/base/unpack.hpp"

namespace ovws {

void unpack(const ImageView& image, int x, int y, int count, std::uint16_t* out) {
  const PixelLattice& lattice = image.lattice;
  // The row ends at the colour plane's last pixel, so nothing beyond the camera's row is read.
  const int pixels = lattice.x + (image.width - 1) * lattice.step + 1;
  const PackedRow row{image.row<std::byte>(lattice.y + y * lattice.step),
                      std::ptrdiff_t(row_bytes(image.format, pixels)), image.left_justified_bits};
  unpack_row(traits_of(image.format).layout, lattice.step)(row, lattice.x + x * lattice.step, count,
                                                           out);
}

}  // namespace ovws
