/// The phase map against the sum of its modes.
#include "core/wavefront/phase_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/optics/zernike.hpp"

namespace ovws {
namespace {

TEST(PhaseMap, ShowsTheSumOfModesAtEachPixel) {
  const std::vector<int> modes{1, 2, 3, 4, 8, 12};
  const std::vector<float> a{0.1F, -0.2F, 0.5F, 0.3F, -0.15F, 0.05F};
  std::vector<Mode> sum;
  for (std::size_t k = 0; k < modes.size(); ++k) sum.push_back({modes[k], double(a[k])});
  for (const int size : {16, 33, 128}) {
    Image<float> waves;
    PhaseMap(modes, size).render(a, waves);
    ASSERT_EQ(waves.width, size);
    ASSERT_EQ(waves.height, size);
    for (int r = 0; r < size; ++r) {
      for (int c = 0; c < size; ++c) {
        const Vec2 at{(2.0 * c + 1) / size - 1, (2.0 * r + 1) / size - 1};
        if (norm(at) > 1.0) {
          EXPECT_TRUE(std::isnan(waves.at(c, r)));
        } else {
          EXPECT_NEAR(waves.at(c, r), wavefront(sum, at), 1e-5);
        }
      }
    }
  }
}

TEST(PhaseMap, HasXToTheRightAndYDown) {
  Image<float> waves;
  const PhaseMap map(std::vector<int>{1, 2}, 32);
  map.render(std::vector<float>{0.0F, 1.0F}, waves);  // j = 2: 2 x
  EXPECT_GT(waves.at(28, 16), 1.0F);
  EXPECT_LT(waves.at(3, 16), -1.0F);
  map.render(std::vector<float>{1.0F, 0.0F}, waves);  // j = 1: 2 y
  EXPECT_GT(waves.at(16, 28), 1.0F);
  EXPECT_LT(waves.at(16, 3), -1.0F);
}

TEST(PhaseMap, HasTheRmsOfItsCoefficients) {
  std::vector<int> modes;
  std::vector<float> a;
  double sum = 0.0;
  for (int j = 1; j <= 18; ++j) {
    modes.push_back(j);
    a.push_back(0.01F * float(j % 5) - 0.02F);
    sum += double(a.back()) * double(a.back());
  }
  Image<float> waves;
  PhaseMap(modes, 256).render(a, waves);
  double squares = 0.0;
  int count = 0;
  for (const float w : waves.pixels) {
    if (std::isnan(w)) continue;
    squares += double(w) * double(w);
    ++count;
  }
  EXPECT_NEAR(std::sqrt(squares / count), std::sqrt(sum), 0.01 * std::sqrt(sum));
}

}  // namespace
}  // namespace ovws
