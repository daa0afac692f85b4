#include "drivers/sdl/x_picture.hpp"

#include <X11/Xutil.h>

namespace ovws::sdl {

Result<Image<std::uint32_t>> colours_of(XImage& image) {
  const bool eight_bits = image.depth == 24 && image.red_mask == 0xff0000UL &&
                          image.green_mask == 0x00ff00UL && image.blue_mask == 0x0000ffUL;
  if (!eight_bits) {
    return fail(Errc::unavailable, "slm.display",
                "the X server's image of the output does not have 8 bits per colour: set "
                "DefaultDepth 24 in its configuration");
  }
  Image<std::uint32_t> picture(image.width, image.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      picture.at(x, y) = std::uint32_t(XGetPixel(&image, x, y) & 0xffffffU);
    }
  }
  return picture;
}

}  // namespace ovws::sdl
