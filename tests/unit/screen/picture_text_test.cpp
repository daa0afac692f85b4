/// Images as characters.
#include "daemon/ovws/screen/picture_text.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace ovws::screen {
namespace {

TEST(PictureText, ShowsASpotOfOnePixel) {
  Image<std::uint8_t> image(64, 32, 10);
  image.at(40, 9) = 255;
  const std::string text = picture_text(image, 16, Shades::ascii);
  // 16 characters of 4 x 8 pixels: 4 lines. The spot is in column 10 of line 1.
  ASSERT_EQ(text.size(), 4U * 17U);
  EXPECT_EQ(text[17 + 10], '@');
  EXPECT_EQ(std::count(text.begin(), text.end(), '@'), 1);
  EXPECT_EQ(std::count(text.begin(), text.end(), ' '), 4 * 16 - 1);
}

TEST(PictureText, ShowsADarkLineOnPaper) {
  Image<std::uint8_t> image(60, 60, 255);
  for (int x = 0; x < 60; ++x) image.at(x, 30) = 0;
  const std::string text = picture_text(image, 20, Shades::ascii);
  EXPECT_EQ(std::count(text.begin(), text.end(), ' '), 20);
  EXPECT_EQ(std::count(text.begin(), text.end(), '@'), 9 * 20);
}

TEST(PictureText, HalfBlocksHaveTwoPixelsInACell) {
  Image<std::uint8_t> image(2, 4, 0);
  image.at(1, 1) = 255;
  EXPECT_EQ(picture_text(image, 2, Shades::blocks),
            "\x1b[38;5;232;48;5;232m▀\x1b[38;5;232;48;5;255m▀\x1b[0m\n"
            "\x1b[38;5;232;48;5;232m▀\x1b[38;5;232;48;5;232m▀\x1b[0m\n");
}

TEST(PictureText, IsEmptyWithoutAnImage) {
  EXPECT_EQ(picture_text({}, 20, Shades::ascii), "");
  EXPECT_EQ(picture_text(Image<std::uint8_t>(4, 4), 0, Shades::ascii), "");
}

TEST(PictureText, EnlargesASmallImage) {
  const Image<std::uint8_t> image(2, 2, 255);
  EXPECT_EQ(picture_text(image, 6, Shades::ascii), "@@@@@@\n@@@@@@\n@@@@@@\n");
}

}  // namespace
}  // namespace ovws::screen
