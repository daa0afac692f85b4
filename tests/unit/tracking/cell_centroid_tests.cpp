#include "core/tracking/cell_centroid.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace ovws {
namespace {

TEST(CellCentroid, IsTheMiddleOfAllLightInTheCell) {
  Image<std::uint8_t> image(20, 20);
  image.at(8, 10) = 100;
  image.at(12, 10) = 100;
  image.at(18, 10) = 255;  // of the neighbour
  const auto found = cell_centroid(view_of(image), {10.3, 10.0}, 4);
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(found->x, 10.0);
  EXPECT_DOUBLE_EQ(found->y, 10.0);
  EXPECT_FALSE(cell_centroid(view_of(image), {2.0, 2.0}, 1));  // dark
}

/// Background biases the textbook sensor's centroid towards the middle of the window.
TEST(CellCentroid, ABackgroundPullsItToTheMiddle) {
  Image<std::uint16_t> image(41, 41, 1);
  image.at(25, 20) = 1 + 41 * 41;  // as much light as the background's
  const auto found = cell_centroid(view_of(image, PixelFormat::mono12), {20.0, 20.0}, 20);
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(found->x, 22.5);
  EXPECT_DOUBLE_EQ(found->y, 20.0);
}

TEST(CellCentroid, IsClippedAtTheImage) {
  const Image<std::uint8_t> image(10, 10, 1);
  const auto found = cell_centroid(view_of(image), {0.0, 0.0}, 2);
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(found->x, 1.0);
  EXPECT_FALSE(cell_centroid(view_of(image), {-50.0, 0.0}, 2));
}

TEST(CellCentroid, CellsOfNeighboursHardlyOverlap) {
  const std::vector<Vec2> centres{{0, 0}, {30, 0}, {0, 21}};
  EXPECT_EQ(cell_half_px(centres), 10);
}

}  // namespace
}  // namespace ovws
