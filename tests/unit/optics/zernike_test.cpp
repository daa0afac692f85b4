/// Zernike modes against their published tables, their orthonormality and finite differences.
#include "core/optics/zernike.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/optics/wavefront_rows.hpp"

namespace ovws {
namespace {

TEST(Zernike, IndexFollowsTheOsaTable) {
  const ZernikeIndex table[] = {{0, 0},  {1, -1}, {1, 1}, {2, -2}, {2, 0},  {2, 2},
                                {3, -3}, {3, -1}, {3, 1}, {3, 3},  {4, -4}, {4, -2},
                                {4, 0},  {4, 2},  {4, 4}, {5, -5}};
  for (int j = 0; j < 16; ++j) {
    EXPECT_EQ(zernike_index(j).n, table[j].n);
    EXPECT_EQ(zernike_index(j).m, table[j].m);
  }
  for (int j = 0; j <= kMaxZernikeIndex; ++j) EXPECT_EQ(osa_index(zernike_index(j)), j);
}

TEST(Zernike, CheckedIndexRefusesWhatIsNoMode) {
  EXPECT_EQ(checked_osa_index(2, -2), 3);
  EXPECT_EQ(checked_osa_index(20, 20), kMaxZernikeIndex);
  EXPECT_FALSE(checked_osa_index(2, 1));
  EXPECT_FALSE(checked_osa_index(2, 4));
  EXPECT_FALSE(checked_osa_index(-1, 1));
  EXPECT_FALSE(checked_osa_index(21, 1));
  EXPECT_FALSE(checked_osa_index(std::numeric_limits<int>::max(), 1));
  EXPECT_FALSE(checked_osa_index(4, std::numeric_limits<int>::min()));
}

TEST(Zernike, NamesAreTheUsualOnes) {
  EXPECT_EQ(zernike_name(1), "vertical tilt");
  EXPECT_EQ(zernike_name(3), "oblique astigmatism");
  EXPECT_EQ(zernike_name(4), "defocus");
  EXPECT_EQ(zernike_name(7), "vertical coma");
  EXPECT_EQ(zernike_name(12), "primary spherical");
  EXPECT_EQ(zernike_name(15), "Z(5,-5)");
}

TEST(Zernike, FirstModesAreTheirTextbookPolynomials) {
  const double x = 0.3;
  const double y = -0.55;
  const double s = x * x + y * y;
  EXPECT_NEAR(zernike(0, {x, y}), 1.0, 1e-15);
  EXPECT_NEAR(zernike(1, {x, y}), 2.0 * y, 1e-15);
  EXPECT_NEAR(zernike(2, {x, y}), 2.0 * x, 1e-15);
  EXPECT_NEAR(zernike(3, {x, y}), std::sqrt(6.0) * 2.0 * x * y, 1e-15);
  EXPECT_NEAR(zernike(4, {x, y}), std::sqrt(3.0) * (2.0 * s - 1.0), 1e-15);
  EXPECT_NEAR(zernike(5, {x, y}), std::sqrt(6.0) * (x * x - y * y), 1e-15);
  EXPECT_NEAR(zernike(7, {x, y}), std::sqrt(8.0) * (3.0 * s - 2.0) * y, 1e-15);
  EXPECT_NEAR(zernike(9, {x, y}), std::sqrt(8.0) * (x * x * x - 3.0 * x * y * y), 1e-15);
  EXPECT_NEAR(zernike(12, {x, y}), std::sqrt(5.0) * (6.0 * s * s - 6.0 * s + 1.0), 1e-15);
}

TEST(Zernike, RmsFactorTurnsUnitAmplitudeIntoRms) {
  EXPECT_DOUBLE_EQ(zernike_rms_factor(3), std::sqrt(6.0));
  EXPECT_DOUBLE_EQ(zernike_rms_factor(4), std::sqrt(3.0));
  for (int j = 0; j <= kMaxZernikeIndex; ++j) {
    // The peak of every mode on the edge is 1 in unit amplitude, at theta = 0 or pi / (2 |m|).
    const int m = zernike_index(j).m;
    const double theta = m < 0 ? std::numbers::pi / (-2.0 * m) : 0.0;
    EXPECT_NEAR(zernike(j, {std::cos(theta), std::sin(theta)}) / zernike_rms_factor(j), 1.0, 1e-6)
        << j;
  }
}

/// Gauss-Legendre nodes and weights on [0, 1] by Newton's method.
void gauss_legendre(int count, std::vector<double>& nodes, std::vector<double>& weights) {
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    double slope = 0.0;
    for (int step = 0; step < 50; ++step) {
      double before = 1.0;
      double value = x;
      for (int k = 2; k <= count; ++k) {
        const double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
        before = value;
        value = next;
      }
      slope = count * (x * value - before) / (x * x - 1.0);
      x -= value / slope;
    }
    nodes.push_back(0.5 * (x + 1.0));
    weights.push_back(1.0 / ((1.0 - x * x) * slope * slope));
  }
}

TEST(Zernike, ModesAreOrthonormalOverTheDisc) {
  // Mean over the disc: exact for polynomials of degree 40, the product of two modes of n = 20.
  std::vector<double> s;
  std::vector<double> weights;
  gauss_legendre(12, s, weights);
  constexpr int kAngles = 48;
  constexpr int kModes = 66;
  std::vector<double> gram(kModes * kModes, 0.0);
  for (std::size_t r = 0; r < s.size(); ++r) {
    for (int a = 0; a < kAngles; ++a) {
      const double theta = 2.0 * std::numbers::pi * a / kAngles;
      const Vec2 at{std::sqrt(s[r]) * std::cos(theta), std::sqrt(s[r]) * std::sin(theta)};
      std::vector<double> values(kModes);
      for (int j = 0; j < kModes; ++j) values[j] = zernike(j, at);
      for (int j = 0; j < kModes; ++j) {
        for (int k = 0; k < kModes; ++k) {
          gram[j * kModes + k] += weights[r] / kAngles * values[j] * values[k];
        }
      }
    }
  }
  for (int j = 0; j < kModes; ++j) {
    for (int k = 0; k < kModes; ++k) {
      EXPECT_NEAR(gram[j * kModes + k], j == k ? 1.0 : 0.0, 1e-11) << j << ' ' << k;
    }
  }
}

TEST(Zernike, GradientsAgreeWithFiniteDifferences) {
  const double h = 1e-5;
  for (int j = 0; j <= 65; ++j) {
    for (const Vec2 at : {Vec2{0.0, 0.0}, Vec2{0.31, 0.0}, Vec2{0.0, -0.44}, Vec2{-0.5, 0.62}}) {
      const Vec2 gradient = zernike_gradient(j, at);
      const double dx = (zernike(j, {at.x + h, at.y}) - zernike(j, {at.x - h, at.y})) / (2.0 * h);
      const double dy = (zernike(j, {at.x, at.y + h}) - zernike(j, {at.x, at.y - h})) / (2.0 * h);
      EXPECT_NEAR(gradient.x, dx, 1e-5) << j;
      EXPECT_NEAR(gradient.y, dy, 1e-5) << j;
    }
  }
}

TEST(Zernike, HighestModesStayBoundedAndFinite) {
  for (int j = 0; j <= kMaxZernikeIndex; ++j) {
    for (double r = 0.0; r <= 1.0; r += 0.01) {
      EXPECT_LE(std::abs(zernike(j, {r, 0.0})), zernike_rms_factor(j) * (1.0 + 1e-6)) << j;
    }
    EXPECT_TRUE(std::isfinite(zernike_gradient(j, {0.0, 0.0}).x)) << j;
  }
}

TEST(Zernike, SumsModes) {
  const std::vector<Mode> modes{{3, 0.5}, {12, -0.2}};
  const Vec2 at{0.4, 0.7};
  EXPECT_NEAR(wavefront(modes, at), 0.5 * zernike(3, at) - 0.2 * zernike(12, at), 1e-15);
  EXPECT_NEAR(wavefront_gradient(modes, at).y,
              0.5 * zernike_gradient(3, at).y - 0.2 * zernike_gradient(12, at).y, 1e-14);
  EXPECT_EQ(wavefront({}, at), 0.0);
}

TEST(Zernike, OptimalModeCountIsThePapers) {
  EXPECT_EQ(optimal_mode_count(5), 18);
  EXPECT_EQ(optimal_mode_count(3), 9);
  EXPECT_EQ(optimal_mode_count(7), 28);
}

class Rows : public ::testing::Test {
 protected:
  static std::vector<Mode> modes_up_to(int last) {
    std::mt19937 random(7);
    std::vector<Mode> modes;
    for (int j = 0; j <= last; ++j) {
      modes.push_back({j, std::uniform_real_distribution(-1.0, 1.0)(random)});
    }
    return modes;
  }
  static constexpr Vec2 kCentre{70.5, 49.5};
  static constexpr double kDiameter = 100.0;
  static Vec2 in_pupil(int x, int y) {
    return {(x - kCentre.x) / (0.5 * kDiameter), (y - kCentre.y) / (0.5 * kDiameter)};
  }
};

TEST_F(Rows, EqualTheDirectSumInsideThePupil) {
  for (const int last : {0, 2, 14, 65, kMaxZernikeIndex}) {
    const auto modes = modes_up_to(last);
    const WavefrontRows rows(modes, kCentre, kDiameter);
    std::vector<double> waves(100);
    for (int y = 0; y < 100; y += 3) {
      rows.waves(y, 21, waves);
      for (int k = 0; k < 100; ++k) {
        const Vec2 at = in_pupil(21 + k, y);
        if (norm(at) > 1.0) continue;
        // A hundredth of the 16-bit phase's step.
        EXPECT_NEAR(waves[k], wavefront(modes, at), 0.01 / 65536.0) << last << ' ' << y;
      }
    }
  }
}

TEST_F(Rows, ContinueOutsideThePupil) {
  const auto modes = modes_up_to(27);
  const WavefrontRows rows(modes, kCentre, kDiameter);
  std::vector<double> waves(142);
  rows.waves(0, 0, waves);
  for (int x = 0; x < 142; ++x) {
    const double truth = wavefront(modes, in_pupil(x, 0));
    EXPECT_NEAR(waves[x], truth, 1e-12 * (1.0 + std::abs(truth)) * 100.0);
  }
}

TEST_F(Rows, SlopesArePerPixel) {
  const auto modes = modes_up_to(65);
  const WavefrontRows rows(modes, kCentre, kDiameter);
  std::vector<double> dx(70);
  std::vector<double> dy(70);
  rows.slopes_x(40, 36, dx);
  rows.slopes_y(40, 36, dy);
  for (int k = 0; k < 70; ++k) {
    const Vec2 truth = (2.0 / kDiameter) * wavefront_gradient(modes, in_pupil(36 + k, 40));
    EXPECT_NEAR(dx[k], truth.x, 1e-8);
    EXPECT_NEAR(dy[k], truth.y, 1e-8);
  }
}

}  // namespace
}  // namespace ovws
