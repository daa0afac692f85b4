/// Spots and changes in camera images.
#include "daemon/examine/commission/light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ovws::commission {
namespace {

Image<float> noise(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> level(0.01F, 0.004F);
  Image<float> image(200, 160);
  for (float& pixel : image.pixels) pixel = level(random);
  return image;
}

Image<float> with_spot(Image<float> image, double x, double y, double radius, double peak) {
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const double r2 = (u - x) * (u - x) + (v - y) * (v - y);
      image.at(u, v) += float(peak * std::exp(-r2 / (radius * radius)));
    }
  }
  return image;
}

TEST(Light, FindsTheSpotThatIsOnlyInOneImage) {
  const auto both = with_spot(noise(1), 30.0, 40.0, 4.0, 0.5);
  const auto spot = spot_in(with_spot(both, 120.3, 90.6, 3.0, 0.7), both);
  ASSERT_TRUE(spot.has_value());
  EXPECT_NEAR(spot->x, 120.3, 0.3);
  EXPECT_NEAR(spot->y, 90.6, 0.3);
}

TEST(Light, FindsNoSpotInNoiseOrWideLight) {
  EXPECT_FALSE(spot_in(noise(1), noise(2)).has_value());
  EXPECT_FALSE(spot_in(with_spot(noise(1), 100.0, 80.0, 120.0, 0.5), noise(2)).has_value());
  EXPECT_FALSE(spot_in(noise(1), with_spot(noise(2), 100.0, 80.0, 3.0, 0.7)).has_value());
  EXPECT_FALSE(spot_in(noise(1), Image<float>(10, 10)).has_value()) << "another region";
}

TEST(Light, ChangeIsRelativeToTheNoise) {
  EXPECT_LT(change(noise(1), noise(2), noise(3)), 1.0);
  EXPECT_GT(change(with_spot(noise(1), 50.0, 50.0, 4.0, 0.5), noise(2),
                   with_spot(noise(3), 50.0, 50.0, 4.0, 0.5)),
            1.0);
  // A spot that comes and goes by itself is no answer to the SLM.
  EXPECT_LT(change(with_spot(noise(1), 50.0, 50.0, 4.0, 0.5), noise(2), noise(3)), 1.0);
}

}  // namespace
}  // namespace ovws::commission
