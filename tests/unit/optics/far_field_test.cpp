/// The far field against a direct sum, and the optics' signs and scales seen through it.
#include "core/optics/far_field.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"
#include "core/optics/chirp_z.hpp"
#include "core/optics/hologram.hpp"

namespace ovws {
namespace {

using Complex = std::complex<float>;

Image<Complex> random_field(const SlmGeometry& slm) {
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  Image<Complex> field(slm.width_px, slm.height_px);
  for (Complex& value : field.pixels) value = {normal(random), normal(random)};
  return field;
}

/// F(u, v) in double, term by term.
std::complex<double> direct_sum(const Image<Complex>& field, double u, double v) {
  std::vector<std::complex<double>> along_x(field.width);
  for (int x = 0; x < field.width; ++x) {
    along_x[x] = std::polar(1.0, -kTwoPi * u * (x - 0.5 * (field.width - 1)));
  }
  std::complex<double> sum = 0.0;
  for (int y = 0; y < field.height; ++y) {
    std::complex<double> line = 0.0;
    for (int x = 0; x < field.width; ++x) {
      line += std::complex<double>(field.at(x, y)) * along_x[x];
    }
    sum += line * std::polar(1.0, -kTwoPi * v * (y - 0.5 * (field.height - 1)));
  }
  return sum;
}

void expect_equal_to_direct_sum(const SlmGeometry& slm, const FarFieldWindow& window) {
  const Image<Complex> field = random_field(slm);
  Image<Complex> out;
  FarField(slm, window).propagate(field, out);
  ASSERT_EQ(out.width, window.cols);
  ASSERT_EQ(out.height, window.rows);
  std::mt19937 random(13);
  // A random field's far field is about as bright everywhere; this is its RMS.
  const double rms = std::sqrt(2.0 * slm.width_px * slm.height_px);
  for (int i = 0; i < 12; ++i) {
    const int c = std::uniform_int_distribution(0, window.cols - 1)(random);
    const int r = std::uniform_int_distribution(0, window.rows - 1)(random);
    const auto truth = direct_sum(field, window.origin_cpp.x + c * window.step_cpp,
                                  window.origin_cpp.y + r * window.step_cpp);
    EXPECT_LT(std::abs(std::complex<double>(out.at(c, r)) - truth), 1e-5 * rms) << c << ' ' << r;
  }
}

TEST(FarField, EqualsTheDirectSumOnThePapersBench) {
  expect_equal_to_direct_sum({}, far_field_window({}, {}, {}, 512, 480));
}

TEST(FarField, EqualsTheDirectSumForOddSizesAndAnyWindow) {
  expect_equal_to_direct_sum({97, 64, 19.0}, {33, 71, {-0.4, 0.3}, 0.0123});
  expect_equal_to_direct_sum({30, 41, 19.0}, {1, 200, {0.0, -0.5}, 1.0 / 317.0});
}

TEST(FarField, EqualsTheDirectSumWhereOneFftIsEnough) {
  expect_equal_to_direct_sum({97, 64, 19.0}, {33, 71, {-0.4, 0.3}, 1.0 / 160.0});
  expect_equal_to_direct_sum({160, 64, 19.0}, {160, 7, {0.1, -0.3}, 1.0 / 160.0});
}

TEST(ChirpZ, GivesTheSameInOrderAndTransposedWithItsGains) {
  constexpr int kLines = 6, kOutputs = 5;
  const Image<Complex> in = random_field({32, kLines, 19.0});
  const std::vector<float> gains{1.0F, 2.0F, -1.0F, 0.5F, 3.0F};
  for (const double step : {1.0 / 48.0, 1.0 / 50.0}) {
    const ChirpAxis axis{in.width, kOutputs, 0.2, step};
    Image<Complex> plain(kLines, kOutputs), transposed = plain, in_order(kOutputs, kLines);
    ChirpZ(axis).transform(in.pixels.data(), kLines, plain.pixels.data(), kLines);
    ChirpZ scaled(axis, gains);
    scaled.transform(in.pixels.data(), kLines, transposed.pixels.data(), kLines);
    scaled.transform_in_order(in.pixels.data(), kLines, in_order.pixels.data());
    for (int line = 0; line < kLines; ++line) {
      for (int k = 0; k < kOutputs; ++k) {
        EXPECT_EQ(in_order.at(k, line), transposed.at(line, k));
        const Complex expected = gains[std::size_t(k)] * plain.at(line, k);
        EXPECT_NEAR(std::abs(in_order.at(k, line) - expected), 0.0, 1e-5);
      }
    }
  }
}

TEST(FarField, CanBeMovedAndUsedAgain) {
  const SlmGeometry slm{40, 30, 19.0};
  const FarFieldWindow window{16, 8, {0.1, 0.1}, 0.01};
  const Image<Complex> field = random_field(slm);
  FarField first(slm, window);
  Image<Complex> a;
  first.propagate(field, a);
  FarField second = std::move(first);
  Image<Complex> b;
  second.propagate(field, b);
  second.propagate(field, b);
  EXPECT_EQ(a.pixels, b.pixels);
}

TEST(FarField, WindowPutsTheBaseFrequencyOnTheBaseSpot) {
  OpticsConfig optics;
  optics.centre_px = Vec2{100.25, 31.5};
  const FarFieldWindow window = far_field_window({}, {}, optics, 512, 300);
  EXPECT_NEAR(window.origin_cpp.x + 100.25 * window.step_cpp, 200.0 / 1280.0, 1e-15);
  EXPECT_NEAR(window.origin_cpp.y + 31.5 * window.step_cpp, 20.0 / 768.0, 1e-15);
  EXPECT_DOUBLE_EQ(window.step_cpp, 1.0 / camera_px_per_cycle(optics, {}));
}

/// The far field of the hologram as shown, light only on the central subaperture.
Image<Complex> central_spot(int charge, std::vector<Mode> modes, const OpticsConfig& optics) {
  HologramConfig config;
  config.sensor.charge = charge;
  Image<std::uint8_t> grey;
  const auto renderer = HologramRenderer::make(config).value();
  renderer.render(HologramKind::sensor, modes, grey);
  Image<Complex> field(grey.width, grey.height);
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      if (std::hypot(x - 639.5, y - 383.5) > renderer.lattice().diameter_px / 2.0) continue;
      field.at(x, y) = Complex(std::polar(1.0, kTwoPi * grey.at(x, y) / 256.0));
    }
  }
  Image<Complex> out;
  FarField(config.slm, far_field_window(config.sensor, config.slm, optics, 128, 96))
      .propagate(field, out);
  return out;
}

/// The bright spot's peak, by a parabola through three points two pixels apart in x and in y.
Vec2 peak_of(const Image<Complex>& out) {
  int best = 0;
  for (int i = 0; i < out.width * out.height; ++i) {
    if (std::norm(out.pixels[i]) > std::norm(out.pixels[best])) best = i;
  }
  const int c = best % out.width;
  const int r = best / out.width;
  const auto vertex = [](double before, double at, double after) {
    return (before - after) / (before - 2.0 * at + after);
  };
  const auto power = [&](int dc, int dr) { return std::norm(out.at(c + dc, r + dr)); };
  return {c + vertex(power(-2, 0), power(0, 0), power(2, 0)),
          r + vertex(power(0, -2), power(0, 0), power(0, 2))};
}

TEST(FarField, CentralSubaperturesSpotFallsOnTheBaseSpot) {
  OpticsConfig optics;
  for (const Vec2 centre : {Vec2{63.5, 47.5}, Vec2{60.25, 51.4}}) {
    optics.centre_px = centre;
    const Vec2 peak = peak_of(central_spot(0, {}, optics));
    EXPECT_NEAR(peak.x, centre.x, 0.01);
    EXPECT_NEAR(peak.y, centre.y, 0.01);
  }
}

TEST(FarField, SpotMovesAlongTheSlopeOfTheWavefront) {
  // W = 2 c x / 384 waves: S * 2 c / 384 camera pixels, in the direction of the rising wavefront.
  const double shift = camera_px_per_cycle({}, {}) * 2.0 * 0.8 / 384.0;
  for (const double sign : {1.0, -1.0}) {
    const Vec2 x_tilted = peak_of(central_spot(0, {{2, sign * 0.8}}, {}));
    EXPECT_NEAR(x_tilted.x, 63.5 + sign * shift, 0.02);
    EXPECT_NEAR(x_tilted.y, 47.5, 0.02);
    const Vec2 y_tilted = peak_of(central_spot(0, {{1, sign * 0.8}}, {}));
    EXPECT_NEAR(y_tilted.x, 63.5, 0.02);
    EXPECT_NEAR(y_tilted.y, 47.5 + sign * shift, 0.02);
  }
}

TEST(FarField, VortexHasADarkCoreAndTheSignOfItsCharge) {
  OpticsConfig optics;
  optics.centre_px = Vec2{64.0, 48.0};
  for (const int charge : {1, -1, 2}) {
    const Image<Complex> out = central_spot(charge, {}, optics);
    const double ring = std::norm(out.at(64 + 12, 48));
    EXPECT_LT(std::norm(out.at(64, 48)), 1e-3 * ring);
    // The phase winds by charge / 4 turns from +x to +y.
    const Complex quarter = out.at(64, 48 + 12) / out.at(64 + 12, 48);
    const double turns = std::arg(quarter) / kTwoPi;
    EXPECT_NEAR(std::remainder(turns - charge / 4.0, 1.0), 0.0, 0.01) << charge;
  }
}

}  // namespace
}  // namespace ovws
