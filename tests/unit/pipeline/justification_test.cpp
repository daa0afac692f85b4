// Detection of MSB-aligned 16-bit pixel data.
#include <gtest/gtest.h>
#include <utility>

#include "core/pipeline/msb_alignment.hpp"
#include "tests/unit/base/packed_image.hpp"

namespace ovws {
namespace {

constexpr int kWidth = 512, kHeight = 64;

/// Dark noise of some DN, and a spot that one row crosses.
Image<std::uint16_t> frame(int spot_row, int spot_dn) {
  Image<std::uint16_t> dn(kWidth, kHeight);
  for (std::size_t k = 0; k < dn.pixels.size(); ++k) dn.pixels[k] = std::uint16_t(k * 7 % 5);
  if (spot_row >= 0) dn.at(100, spot_row) = std::uint16_t(spot_dn);
  return dn;
}

int settled(MsbAlignmentDetector& detector, const Image<std::uint16_t>& dn, PixelFormat format,
            int shift, int frames = kHeight) {
  const auto bytes = test::pack(dn, format, 0, shift);
  int bits = 0;
  for (int k = 0; k < frames; ++k) {
    bits = detector.shift_bits(test::packed_view(bytes, dn.width, dn.height, format));
  }
  return bits;
}

TEST(Justified, ToTheLeftIsSeenByANumberAboveFullScale) {
  for (const auto& [format, shift] : {std::pair{PixelFormat::mono10, 6},
                                      {PixelFormat::mono12, 4},
                                      {PixelFormat::mono14, 2},
                                      {PixelFormat::bayer_rg10, 6},
                                      {PixelFormat::bayer_bg12, 4}}) {
    MsbAlignmentDetector detector;
    EXPECT_EQ(settled(detector, frame(33, int(full_scale_dn(format)) / 2), format, shift), shift)
        << pixel_format_name(format);
    // Once detected, it holds for dark frames, too.
    EXPECT_EQ(settled(detector, frame(-1, 0), format, shift, 1), shift);
  }
}

TEST(Justified, ToTheRightIsLeftAlone) {
  MsbAlignmentDetector detector;
  EXPECT_EQ(settled(detector, frame(33, 4095), PixelFormat::mono12, 0), 0);
}

TEST(Justified, NothingIsSaidOfFormatsWithoutSpareBits) {
  MsbAlignmentDetector detector;
  for (const PixelFormat format :
       {PixelFormat::mono8, PixelFormat::mono16, PixelFormat::mono12p, PixelFormat::bayer_gr8}) {
    EXPECT_EQ(settled(detector, frame(33, 255), format, 0), 0) << pixel_format_name(format);
  }
}

// A converter of fewer bits leaves low bits empty in LSB-aligned data, too.
TEST(Justified, EmptyLowBitsAloneProveNothing) {
  Image<std::uint16_t> dn = frame(33, 255);
  for (std::uint16_t& pixel : dn.pixels) pixel = std::uint16_t(pixel << 4);
  MsbAlignmentDetector detector;
  EXPECT_EQ(settled(detector, dn, PixelFormat::mono12, 0), 0);
}

TEST(Justified, IsFoundAnewForAnotherFormatAndAnotherStream) {
  MsbAlignmentDetector detector;
  EXPECT_EQ(settled(detector, frame(33, 1000), PixelFormat::mono12, 4), 4);
  EXPECT_EQ(settled(detector, frame(33, 1000), PixelFormat::mono10, 0), 0);
  EXPECT_EQ(settled(detector, frame(33, 1000), PixelFormat::mono12, 4), 4);
  detector.reset();
  EXPECT_EQ(settled(detector, frame(-1, 0), PixelFormat::mono12, 4, 1), 0);
}

}  // namespace
}  // namespace ovws
