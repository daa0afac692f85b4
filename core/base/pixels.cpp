#include "core/base/pixels.hpp"

#include "core/base/unpack.hpp"

namespace ovws {

void unpack(const ImageView& image, int x, int y, int count, std::uint16_t* out) {
  const ColourPlane& plane = image.plane;
  // The row ends at the colour plane's last pixel, so nothing beyond the camera's row is read.
  const int pixels = plane.x + (image.width - 1) * plane.step + 1;
  const PackedRow row{image.row<std::byte>(plane.y + y * plane.step),
                      std::ptrdiff_t(row_bytes(image.format, pixels)), image.left_justified_bits};
  unpack_row(traits_of(image.format).layout, plane.step)(row, plane.x + x * plane.step, count, out);
}

}  // namespace ovws
