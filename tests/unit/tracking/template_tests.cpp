/// Parts of the matched filter: shapes, template banks, and the SIMD kernels of every instruction
/// set.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/tracking/reference_shape.hpp"
#include "core/tracking/spot_geometry.hpp"
#include "core/tracking/template_bank.hpp"
#include "core/tracking/template_sums.hpp"

namespace ovws {
namespace {

constexpr double kLambdaD = 12.55;

TEST(ModelShape, IsTheSpotsProfileWithItsGradient) {
  for (const int charge : {0, 1, -2}) {
    const ModelShape shape({charge, kLambdaD}, 4.0);
    const double peak = spot_intensity(charge, spot_geometry(charge).ring);
    for (double r = 0.0; r < 4.0; r += 0.0713) {
      const Vec2 at = r * kLambdaD * Vec2{0.6, -0.8};
      const ShapeSample s = shape.at(at);
      EXPECT_NEAR(s.value, spot_intensity(charge, r) / peak, 2e-5) << r;
      constexpr double kStep = 1e-4;
      EXPECT_NEAR(s.dx, (shape.at(at + Vec2{kStep, 0}).value - s.value) / kStep, 1e-5) << r;
      EXPECT_NEAR(s.dy, (shape.at(at + Vec2{0, kStep}).value - s.value) / kStep, 1e-5) << r;
    }
  }
}

TEST(ReferenceShape, IsTheLightItWasMadeOf) {
  const SpotModel spots{1, kLambdaD};
  const ModelShape model(spots, 6.0);
  const TemplateBank bank(spots, model);
  const Vec2 position{60.3, 59.6};
  Image<float> average(128, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 128; ++x) {
      average.at(x, y) =
          float(40.0 + 700.0 * model.at(Vec2{double(x), double(y)} - position).value);
    }
  }
  const ReferenceShape shape(spots, bank, average, position);
  ASSERT_TRUE(shape.usable());
  for (double r = 0.0; r < 1.9 * kLambdaD; r += 1.37) {
    const Vec2 at = r * Vec2{std::cos(r), std::sin(r)};
    const ShapeSample a = shape.at(at), b = model.at(at);
    EXPECT_NEAR(a.value, b.value, 0.005) << r;
    EXPECT_NEAR(a.dx, b.dx, 0.002) << r;
    EXPECT_NEAR(a.dy, b.dy, 0.002) << r;
  }
}

TEST(ReferenceShape, TakesMostOfThePixelsNoiseOut) {
  const SpotModel spots{0, kLambdaD};
  const TemplateBank bank(spots, ModelShape(spots, 4.0));
  std::mt19937 random(1);
  std::normal_distribution<float> noise;
  const ModelShape model(spots, 6.0);
  Image<float> average(128, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 128; ++x) {
      const double value = model.at(Vec2{x - 60.0, y - 60.0}).value;
      average.at(x, y) = float(value) + 0.1F * noise(random);
    }
  }
  const ReferenceShape shape(spots, bank, average, {60, 60});
  double sum = 0.0;
  int count = 0;
  for (int y = -15; y <= 15; ++y) {
    for (int x = -15; x <= 15; ++x, ++count) {
      const Vec2 at{double(x), double(y)};
      sum += std::pow(shape.at(at).value - model.at(at).value, 2);
    }
  }
  EXPECT_LT(std::sqrt(sum / count), 0.3 * 0.1);
}

TEST(TemplateBank, PlacesAtTheNearestShift) {
  const SpotModel spots{1, kLambdaD};
  const TemplateBank bank(spots, ModelShape(spots, 4.0));
  EXPECT_DOUBLE_EQ(bank.step_px(), 0.25);
  EXPECT_TRUE(bank.regular());
  for (double x = 20.0; x < 22.0; x += 0.013) {
    const auto place = bank.place({x, 41.9 - x});
    EXPECT_LE(std::abs(place.centre.x - x), 0.125 + 1e-9);
    EXPECT_LE(std::abs(place.centre.y - (41.9 - x)), 0.125 + 1e-9);
    EXPECT_LE(std::abs(place.centre.x - place.x), 0.5);
    const TemplateView view = bank.view(place, kMiddleNoise);
    // The template's dark core is at the place's centre.
    const int column = view.columns / 2 + int(std::lround(place.centre.x - place.x));
    EXPECT_LT(view.value[view.rows / 2 * view.columns + column], 0.02F);
  }
}

TEST(TemplateBank, WeighsNothingOutsideItsDiscAndKnowsItsParts) {
  for (const int charge : {0, 1, 2}) {
    const SpotModel spots{charge, kLambdaD};
    const TemplateBank bank(spots, ModelShape(spots, 4.0));
    const double radius = matched_window(charge) * kLambdaD;
    EXPECT_NEAR(bank.pixels(), M_PI * radius * radius, 0.02 * M_PI * radius * radius);
    EXPECT_NEAR(bank.mean_bright(), 0.76, 0.06);
    const auto& parts = bank.parts();
    for (int i = 0; i < TemplateBank::Parts::kSectors; ++i) {
      EXPECT_GT(parts.begin[i + 1] - parts.begin[i], 20);
      EXPECT_GT(parts.value[i], 0.5F);
    }
    constexpr int kCore = TemplateBank::Parts::kSectors;
    EXPECT_EQ(parts.begin[kCore + 1] > parts.begin[kCore], charge != 0);
  }
}

TEST(TemplateKernels, OfEveryInstructionSetAgree) {
  const auto kernels = template_kernels();
  ASSERT_FALSE(kernels.empty());
  const SpotModel spots{1, kLambdaD};
  const TemplateBank bank(spots, ModelShape(spots, 4.0));
  const TemplateView view = bank.view(bank.place({30.3, 30.1}), kMiddleNoise);
  std::mt19937 random(2);
  std::uniform_real_distribution<float> pixel(0.0F, 4000.0F);
  std::vector<float> pixels(std::size_t(view.columns * view.rows)), line(std::size_t(view.columns));
  for (float& p : pixels) p = pixel(random);
  const TemplateFit fit{1800.0F, 300.0F, 20.0F, -15.0F};
  const TemplateMoments m = kernels.front().moments(view, pixels.data());
  const ResidualSums r = kernels.front().residuals(view, pixels.data(), fit, line.data());
  double one = 0.0, square = 0.0, difference = 0.0;
  std::vector<double> above(std::size_t(view.columns));
  for (int k = 0; k < view.columns * view.rows; ++k) {
    const double w = double(view.weight[k]);
    const double d = double(pixels[k]) - 1800.0 - 300.0 * double(view.value[k]) -
                     20.0 * double(view.cx[k]) + 15.0 * double(view.cy[k]);
    double& last = above[std::size_t(k % view.columns)];
    if (k >= view.columns) difference += 0.5 * w * (d - last) * (d - last);
    last = d;
    one += w * double(pixels[k]);
    square += w * d * d;
  }
  EXPECT_NEAR(m.one / one, 1.0, 1e-5);
  EXPECT_NEAR(r.square / square, 1.0, 1e-5);
  EXPECT_NEAR(r.difference / difference, 1.0, 1e-5);
  for (const TemplateKernels& kernel : kernels) {
    const TemplateMoments n = kernel.moments(view, pixels.data());
    const ResidualSums s = kernel.residuals(view, pixels.data(), fit, line.data());
    EXPECT_NEAR(n.one, m.one, 1e-5 * one) << kernel.name;
    EXPECT_NEAR(n.value, m.value, 1e-5 * one) << kernel.name;
    EXPECT_NEAR(n.cx, m.cx, 1e-5 * one) << kernel.name;
    EXPECT_NEAR(n.cy, m.cy, 1e-5 * one) << kernel.name;
    EXPECT_NEAR(s.square / r.square, 1.0, 1e-5) << kernel.name;
    EXPECT_NEAR(s.difference / r.difference, 1.0, 1e-5) << kernel.name;
    EXPECT_NEAR(s.dark / r.dark, 1.0, 1e-5) << kernel.name;
    EXPECT_NEAR(s.bright / r.bright, 1.0, 1e-5) << kernel.name;
  }
}

}  // namespace
}  // namespace ovws
