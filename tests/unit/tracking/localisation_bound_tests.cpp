/// The Cramer-Rao bound against analytic results.
#include "core/tracking/localisation_bound.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ovws {
namespace {

constexpr double kSigma = 3.0;  ///< of the Gaussian spot, px

struct Gaussian final : SpotShape {
  ShapeSample at(Vec2 p) const override {
    const double value = std::exp(-0.5 * (p.x * p.x + p.y * p.y) / (kSigma * kSigma));
    return {value, -value * p.x / (kSigma * kSigma), -value * p.y / (kSigma * kSigma)};
  }
};

struct Flat final : SpotShape {
  ShapeSample at(Vec2) const override { return {1.0, 0.0, 0.0}; }
};

TEST(LocalisationBound, OfAGaussianUnderReadNoiseIsSigmaOverPeakAndRootOfHalfPi) {
  // sum (dI/dx)^2 = P^2 pi / 2, whatever the spot's width. Read noise must dominate shot noise.
  const SpotExposure exposure{1.0, 0.0, 1000.0};
  const auto bound = localisation_bound(Gaussian{}, {0.3, -0.2}, 25, exposure);
  EXPECT_NEAR(bound.px_known, 1000.0 / std::sqrt(M_PI / 2.0), 0.01);
  EXPECT_NEAR(bound.px, bound.px_known, 0.01)
      << "symmetric: amplitude and background do not matter";
}

TEST(LocalisationBound, OfAGaussianUnderShotNoiseIsItsWidthOverRootOfElectrons) {
  const SpotExposure exposure{500.0, 0.0, 0.0};
  const double electrons = 500.0 * 2.0 * M_PI * kSigma * kSigma;
  const auto bound = localisation_bound(Gaussian{}, {0.3, -0.2}, 25, exposure);
  EXPECT_NEAR(bound.px_known, kSigma / std::sqrt(electrons), 1e-5);
}

TEST(LocalisationBound, GrowsWithNoiseAndShrinksWithLightAndWindow) {
  const ModelShape vortex({1, 12.55}, 6.0);
  const auto px = [&](const SpotExposure& exposure, int half) {
    return localisation_bound(vortex, {0.1, 0.2}, half, exposure).px;
  };
  EXPECT_LT(px({500, 0, 5}, 32), px({500, 0, 10}, 32));
  EXPECT_LT(px({500, 0, 5}, 32), px({500, 50, 5}, 32));
  EXPECT_LT(px({1000, 0, 5}, 32), px({500, 0, 5}, 32));
  EXPECT_LT(px({500, 0, 5}, 32), px({500, 0, 5}, 18));
}

TEST(LocalisationBound, OfWhatIsCutByTheWindowIsWorseWithAmplitudeUnknown) {
  const auto bound = localisation_bound(Gaussian{}, {0.4, 0.0}, 2, {500.0, 0.0, 10.0});
  EXPECT_GT(bound.px, 1.001 * bound.px_known);
}

TEST(LocalisationBound, OfAFlatImageIsInfinite) {
  const auto bound = localisation_bound(Flat{}, {0, 0}, 10, {500.0, 0.0, 10.0});
  EXPECT_TRUE(std::isinf(bound.px));
  EXPECT_TRUE(std::isinf(bound.px_known));
}

}  // namespace
}  // namespace ovws
