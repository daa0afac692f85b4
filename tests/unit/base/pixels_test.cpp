// visit_rows on regions of images in every format gives back the pixels that were packed.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/pixels.hpp"
#include "tests/unit/base/packed_image.hpp"

namespace ovws {
namespace {

struct Place {
  int left, top, columns, rows;
};

class Pixels : public testing::TestWithParam<PixelFormat> {
 protected:
  static constexpr int kWidth = 612, kHeight = 14;  // wider than two runs
  static constexpr std::size_t kPadding = 5;

  /// Every pixel of the rectangle is visited once and equals `expected(x, y)`.
  template <class Expected>
  static void expect_visited(const ImageView& view, const Place& at, Expected expected) {
    Image<int> visits(at.columns, at.rows);
    visit_rows(view, at.left, at.top, at.columns, at.rows,
               [&](int x, int y, const auto* pixels, int count) {
                 for (int i = 0; i < count; ++i) {
                   ++visits.at(x + i - at.left, y - at.top);
                   ASSERT_EQ(int(pixels[i]), int(expected(x + i, y))) << x + i << ", " << y;
                 }
               });
    for (const int n : visits.pixels) ASSERT_EQ(n, 1);
  }

  PixelFormat format_ = GetParam();
  Image<std::uint16_t> picture_ = test::random_image(kWidth, kHeight, format_, 11);
};

TEST_P(Pixels, OfARegionAreThoseOfTheImage) {
  const std::vector<std::byte> bytes = test::pack(picture_, format_, kPadding);
  const ImageView view = test::packed_view(bytes, kWidth, kHeight, format_, kPadding);
  for (const Place& at : {Place{0, 0, kWidth, kHeight}, Place{37, 3, 300, 5},
                          Place{kWidth - 1, kHeight - 1, 1, 1}, Place{5, 5, 0, 0}}) {
    expect_visited(view, at, [&](int x, int y) { return picture_.at(x, y); });
  }
}

TEST_P(Pixels, OfAColourPlaneAreEverySecondOfTheImage) {
  const std::vector<std::byte> bytes = test::pack(picture_, format_, kPadding);
  const ImageView whole = test::packed_view(bytes, kWidth, kHeight, format_, kPadding);
  for (const ColourPlane& plane :
       {ColourPlane{2, 0, 0}, ColourPlane{2, 1, 0}, ColourPlane{2, 0, 1}, ColourPlane{2, 1, 1}}) {
    const ImageView view = on_plane(whole, plane);
    ASSERT_EQ(view.width, kWidth / 2);
    ASSERT_EQ(view.height, kHeight / 2);
    for (const Place& at : {Place{0, 0, view.width, view.height}, Place{17, 2, 270, 3}}) {
      expect_visited(view, at,
                     [&](int x, int y) { return picture_.at(plane.x + 2 * x, plane.y + 2 * y); });
    }
  }
}

class PixelWords : public Pixels {};
TEST_P(PixelWords, ThatAreLeftJustifiedAreMovedDown) {
  const PixelFormatTraits& traits = traits_of(format_);
  const int shift = 16 - traits.bits;
  const std::vector<std::byte> bytes = test::pack(picture_, format_, 0, shift);
  const ImageView view = test::packed_view(bytes, kWidth, kHeight, format_, 0, shift);
  EXPECT_EQ(in_place(view), shift == 0);
  expect_visited(view, {3, 1, 600, 12}, [&](int x, int y) { return picture_.at(x, y); });
}

TEST(PixelsOfAPicture, AreReadWhereTheyLie) {
  const Image<std::uint8_t> picture(20, 10, std::uint8_t(3));
  const ImageView view = view_of(picture);
  visit_rows(view, 4, 2, 9, 1, [&](int x, int y, const auto* pixels, int count) {
    EXPECT_EQ(x, 4);
    EXPECT_EQ(y, 2);
    EXPECT_EQ(count, 9);
    EXPECT_EQ(static_cast<const void*>(pixels), picture.row(2) + 4);
  });
}

std::vector<PixelFormat> formats(bool words_only) {
  std::vector<PixelFormat> some;
  for (const PixelFormatTraits& format : all_pixel_formats()) {
    const bool word = format.layout == PixelLayout::words;
    if (word || !words_only) some.push_back(format.format);
  }
  return some;
}

INSTANTIATE_TEST_SUITE_P(All, Pixels, testing::ValuesIn(formats(false)), test::format_name);
INSTANTIATE_TEST_SUITE_P(All, PixelWords, testing::ValuesIn(formats(true)), test::format_name);

}  // namespace
}  // namespace ovws
