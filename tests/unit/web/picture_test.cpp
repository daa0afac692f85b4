#include "daemon/web/picture.hpp"

#include <gtest/gtest.h>

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

TEST(ImageTest, RefusesAnImageThatIsNotWhatItSays) {
  auto image = image_of<std::uint8_t>(3, 5, [](int, int) { return std::uint8_t(0); });
  image.binary.pop_back();
  EXPECT_FALSE(reduced_image(image));
  image.json = "[]";
  EXPECT_FALSE(reduced_image(image));
}

}  // namespace
}  // namespace ovws::web
