#include "daemon/web/picture.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

namespace ovws::web {
namespace {

using nlohmann::json;

template <class Pixel>
StreamMessage image_of(int rows, int cols, Pixel (*value)(int x, int y)) {
  std::vector<Pixel> pixels;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) pixels.push_back(value(x, y));
  }
  const json header{{"shape", {rows, cols}}, {"dtype", sizeof(Pixel) == 1 ? "<u1" : "<u2"}};
  StreamMessage message{"image", header.dump(), {}};
  message.binary.resize(pixels.size() * sizeof(Pixel));
  std::memcpy(message.binary.data(), pixels.data(), message.binary.size());
  return message;
}

TEST(ImageTest, LeavesASmallImageAsItIs) {
  const auto image = image_of<std::uint8_t>(3, 5, [](int x, int y) { return std::uint8_t(x * y); });
  const auto reduced = reduced_image(image);
  ASSERT_TRUE(reduced);
  EXPECT_EQ(reduced->binary, image.binary);
  EXPECT_EQ(json::parse(reduced->json)["reduced_by"], 1);
}

TEST(ImageTest, AveragesALargeOne) {
  const auto image = image_of<std::uint16_t>(
      6, 2050, [](int x, int y) { return std::uint16_t(1000 * (x / 3) % 65000 + 3 * (y % 3)); });
  const auto reduced = reduced_image(image);
  ASSERT_TRUE(reduced);
  const json header = json::parse(reduced->json);
  EXPECT_EQ(header["reduced_by"], 3);
  EXPECT_EQ(header["shape"], (json{2, 683}));
  std::vector<std::uint16_t> pixels(2 * 683);
  ASSERT_EQ(reduced->binary.size(), pixels.size() * 2);
  std::memcpy(pixels.data(), reduced->binary.data(), reduced->binary.size());
  for (int x = 0; x < 683; ++x) {
    EXPECT_EQ(pixels[std::size_t(x)], 1000 * x % 65000 + 3) << x;
    EXPECT_EQ(pixels[std::size_t(683 + x)], 1000 * x % 65000 + 3) << x;
  }
}

TEST(ImageTest, CountsLevelsOfTheCamerasPixelsAndShowsEverySaturatedOne) {
  const auto image = image_of<std::uint8_t>(
      2, 2048, [](int x, int y) { return std::uint8_t(y == 1 && x == 11 ? 255 : 10); });
  const auto reduced = reduced_image(image);
  ASSERT_TRUE(reduced);
  const json header = json::parse(reduced->json);
  EXPECT_EQ(header["reduced_by"], 2);
  EXPECT_EQ(header["saturated_pixels"], 1);
  EXPECT_EQ(header["brightest_dn"], 255);
  EXPECT_EQ(header["histogram"].size(), kHistogramBins);
  EXPECT_EQ(header["histogram"][5], 4095);
  EXPECT_EQ(header["histogram"][127], 1);
  EXPECT_EQ(int(reduced->binary[5]), 255);
  EXPECT_EQ(int(reduced->binary[4]), 10);
}

TEST(ImageTest, CutsOutAPartWithItsPlace) {
  const auto image =
      image_of<std::uint16_t>(20, 30, [](int x, int y) { return std::uint16_t(100 * y + x); });
  const auto part = image_part(image, {25, 3, 10, 2});
  ASSERT_TRUE(part);
  const json header = json::parse(part->json);
  EXPECT_EQ(header["shape"], (json{2, 5}));
  EXPECT_EQ(header["x"], 25);
  EXPECT_EQ(header["y"], 3);
  std::vector<std::uint16_t> pixels(10);
  ASSERT_EQ(part->binary.size(), pixels.size() * 2);
  std::memcpy(pixels.data(), part->binary.data(), part->binary.size());
  EXPECT_EQ(pixels, (std::vector<std::uint16_t>{325, 326, 327, 328, 329, 425, 426, 427, 428, 429}));
  EXPECT_FALSE(image_part(image, {30, 0, 5, 5}));
  EXPECT_FALSE(image_part(image, {0, 0, 0, 5}));
}

TEST(ImageTest, ReadsTheQueryOfAPart) {
  const auto part = parse_image_part("x=1&y=2&width=30&height=40");
  ASSERT_TRUE(part);
  EXPECT_EQ((std::vector{part->x, part->y, part->width, part->height}),
            (std::vector{1, 2, 30, 40}));
  for (const char* query : {"", "x=1", "x=1&y=2&width=30&height=40&", "x=-1&y=2&width=3&height=4",
                            "x=1&y=2&width=99999999999&height=4", "y=1&x=2&width=3&height=4"}) {
    EXPECT_FALSE(parse_image_part(query)) << query;
  }
}

TEST(ImageTest, RefusesAnImageThatIsNotWhatItSays) {
  auto image = image_of<std::uint8_t>(3, 5, [](int, int) { return std::uint8_t(0); });
  image.binary.pop_back();
  EXPECT_FALSE(reduced_image(image));
  image.json = "[]";
  EXPECT_FALSE(reduced_image(image));
}

}  // namespace
}  // namespace ovws::web
