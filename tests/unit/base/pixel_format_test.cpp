// Pixel formats: names, sizes, and the colour plane of a Bayer camera for each wavelength.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/pixel_format.hpp"

namespace ovws {
namespace {

TEST(PixelFormats, EachHasANameOfItsOwnByWhichItIsFound) {
  std::set<std::string_view> names;
  for (const PixelFormatTraits& format : all_pixel_formats()) {
    EXPECT_TRUE(names.insert(format.name).second) << format.name;
    EXPECT_EQ(pixel_format_from_name(format.name), format.format) << format.name;
  }
  EXPECT_FALSE(pixel_format_from_name("Mono17"));
  EXPECT_FALSE(pixel_format_from_name("mono8"));
}

TEST(PixelFormats, NamesContainTheBitsAndTheFirstTwoFilters) {
  for (const PixelFormatTraits& format : all_pixel_formats()) {
    const std::string name(format.name);
    EXPECT_NE(name.find(std::to_string(format.bits)), std::string::npos) << name;
    const bool bayer = name.starts_with("Bayer");
    EXPECT_EQ(format.filter == ColourFilter::none, !bayer) << name;
    if (!bayer) continue;
    const std::vector<std::string> filters{"", "RG", "GR", "GB", "BG"};
    EXPECT_EQ(name.substr(5, 2), filters[std::size_t(format.filter)]);
  }
}

TEST(PixelFormats, RowsTakeTheBytesThatTheirBitsNeed) {
  EXPECT_EQ(row_bytes(PixelFormat::mono8, 101), 101U);
  EXPECT_EQ(row_bytes(PixelFormat::bayer_gb12, 101), 202U);
  EXPECT_EQ(row_bytes(PixelFormat::mono10p, 512), 640U);
  EXPECT_EQ(row_bytes(PixelFormat::bayer_bg12p, 512), 768U);
  EXPECT_EQ(row_bytes(PixelFormat::mono10_packed, 512), 768U);
  EXPECT_EQ(row_bytes(PixelFormat::mono12_packed, 512), 768U);
}

TEST(PixelFormats, ARowOfWholeGroupsEndsAtAWholeByte) {
  for (const PixelFormatTraits& format : all_pixel_formats()) {
    const int group = pixels_per_group(format.format);
    EXPECT_EQ(row_bytes(format.format, 2 * group), 2 * row_bytes(format.format, group))
        << format.name;
  }
}

/// The filter over each pixel of the repeating square, as the format's name spells the first row.
char filter_at(PixelFormat format, int x, int y) {
  const std::string first(pixel_format_name(format).substr(5, 2));
  const std::string second = first == "RG"   ? "GB"
                             : first == "GR" ? "BG"
                             : first == "GB" ? "RG"
                                             : "GR";
  return (y == 0 ? first : second)[std::size_t(x)];
}

TEST(LitPixels, AreThoseUnderTheFilterOfTheLasersColour) {
  const std::vector<std::pair<double, char>> lasers{{405.0, 'B'}, {488.0, 'B'}, {532.0, 'G'},
                                                    {561.0, 'G'}, {594.0, 'R'}, {632.8, 'R'},
                                                    {780.0, 'R'}};
  for (const PixelFormatTraits& format : all_pixel_formats()) {
    for (const auto& [nm, colour] : lasers) {
      const LitPixels lit = lit_pixels(format.format, nm);
      if (format.filter == ColourFilter::none) {
        EXPECT_TRUE(lit.plane.everything() && !lit.diagonal) << format.name;
        continue;
      }
      ASSERT_EQ(lit.plane.step, 2) << format.name;
      EXPECT_EQ(filter_at(format.format, lit.plane.x, lit.plane.y), colour)
          << format.name << " at " << nm;
      EXPECT_EQ(lit.diagonal, colour == 'G');
      if (!lit.diagonal) continue;
      EXPECT_EQ(filter_at(format.format, lit.other().x, lit.other().y), 'G') << format.name;
      EXPECT_FALSE(lit.other() == lit.plane);
    }
  }
}

TEST(ColourPlane, TurnsPositionsAsItsPixelsLie) {
  const ColourPlane plane{2, 1, 0};
  EXPECT_EQ(plane.to_image({0.0, 0.0}), (Vec2{1.0, 0.0}));
  EXPECT_EQ(plane.to_image({10.25, 3.5}), (Vec2{21.5, 7.0}));
  EXPECT_EQ(plane.from_image({21.5, 7.0}), (Vec2{10.25, 3.5}));
  EXPECT_EQ(plane.count(8, 1), 4);
  EXPECT_EQ(plane.count(7, 1), 3);
  EXPECT_EQ(plane.count(7, 0), 4);
}

}  // namespace
}  // namespace ovws
