/// Images in the formats of other X servers, tested without a server.
#include <gtest/gtest.h>

#include <array>

// Last: Xlib has macros like None that would break the others.
#include <X11/Xutil.h>

#include "drivers/sdl/x_server.hpp"

namespace ovws::sdl {
namespace {

constexpr int kWidth = 3, kHeight = 2;

struct Masks {
  unsigned long red = 0xff0000, green = 0x00ff00, blue = 0x0000ff;
};

/// Pixel k is 0x102030 + k; the unused byte of each pixel, or the padding of each line, holds
/// garbage.
class Picture {
 public:
  Picture(int byte_order, int bits_per_pixel, int depth = 24, Masks masks = {}) {
    image_.width = kWidth;
    image_.height = kHeight;
    image_.format = ZPixmap;
    image_.data = bytes_.data();
    image_.byte_order = byte_order;
    image_.bitmap_unit = 32;
    image_.bitmap_bit_order = byte_order;
    image_.bitmap_pad = 32;
    image_.depth = depth;
    image_.bits_per_pixel = bits_per_pixel;
    image_.red_mask = masks.red;
    image_.green_mask = masks.green;
    image_.blue_mask = masks.blue;
    bytes_.fill(char(0xee));
    EXPECT_TRUE(XInitImage(&image_));
    const int size = bits_per_pixel / 8;
    for (int k = 0; k < kWidth * kHeight; ++k) {
      for (int byte = 0; byte < 3; ++byte) {
        const int at = byte_order == LSBFirst ? byte : size - 1 - byte;
        bytes_[std::size_t(k / kWidth * image_.bytes_per_line + k % kWidth * size + at)] =
            char((0x102030 + k) >> (8 * byte));
      }
    }
  }
  XImage& image() { return image_; }

 private:
  std::array<char, 256> bytes_{};
  XImage image_{};
};

TEST(XPicture, IsTheSameInEveryOrderOfBytes) {
  for (const int byte_order : {LSBFirst, MSBFirst}) {
    for (const int bits_per_pixel : {24, 32}) {
      Picture seen(byte_order, bits_per_pixel);
      const auto colours = colours_of(seen.image());
      ASSERT_TRUE(colours) << colours.error().reason;
      ASSERT_EQ(colours->width, kWidth);
      ASSERT_EQ(colours->height, kHeight);
      for (std::size_t k = 0; k < colours->pixels.size(); ++k) {
        EXPECT_EQ(colours->pixels[k], 0x102030U + k) << byte_order << " " << bits_per_pixel;
      }
    }
  }
}

TEST(XPicture, OfOtherColoursIsRefusedWithTheRemedy) {
  Picture swapped(LSBFirst, 32, 24, {0x0000ff, 0x00ff00, 0xff0000});
  Picture of_30_bits(LSBFirst, 32, 30, {0x3ff00000, 0x000ffc00, 0x000003ff});
  Picture of_16_bits(LSBFirst, 32, 16, {0xf800, 0x07e0, 0x001f});
  for (Picture* seen : {&swapped, &of_30_bits, &of_16_bits}) {
    const auto refused = colours_of(seen->image());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::unavailable);
    EXPECT_NE(refused.error().reason.find("DefaultDepth 24"), std::string::npos);
  }
}

}  // namespace
}  // namespace ovws::sdl
