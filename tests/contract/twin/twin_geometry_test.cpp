/// Camera geometry in the far field: rotation, mirror, magnification, shift.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <random>

#include "core/base/angle.hpp"
#include "core/optics/hologram.hpp"
#include "drivers/twin/bench_model.hpp"
#include "drivers/twin/camera_map.hpp"
#include "tests/contract/twin/model_case.hpp"

namespace ovws::twin {
namespace {

Image<std::uint8_t> random_greys() {
  Image<std::uint8_t> grey(1280, 768);
  std::mt19937 random(5);
  for (std::uint8_t& pixel : grey.pixels) pixel = std::uint8_t(random());
  return grey;
}

/// Direct Fourier sum F(u) in double precision.
std::complex<double> direct_sum(const Image<std::complex<float>>& field, Vec2 cpp) {
  std::vector<std::complex<double>> along_x;
  for (int x = 0; x < field.width; ++x) {
    along_x.push_back(std::polar(1.0, -kTwoPi * cpp.x * (x - (field.width - 1) / 2.0)));
  }
  std::complex<double> sum = 0.0;
  for (int y = 0; y < field.height; ++y) {
    double re = 0.0, im = 0.0;
    for (int x = 0; x < field.width; ++x) {
      const std::complex<double> a = field.at(x, y), b = along_x[std::size_t(x)];
      re += a.real() * b.real() - a.imag() * b.imag();
      im += a.real() * b.imag() + a.imag() * b.real();
    }
    sum += std::complex<double>(re, im) *
           std::polar(1.0, -kTwoPi * cpp.y * (y - (field.height - 1) / 2.0));
  }
  return sum;
}

/// Independent implementation of the definition: centre + S R M u.
Vec2 defined_px(const CameraGeometry& g, Vec2 cpp_from_base) {
  const double scale = 632e-9 * 0.2 * g.magnification / (19e-6 * 3.45e-6);
  const double angle = g.rotation_deg * std::numbers::pi / 180.0;
  const double x = scale * cpp_from_base.x * (g.mirror == Mirror::x ? -1.0 : 1.0);
  const double y = scale * cpp_from_base.y * (g.mirror == Mirror::y ? -1.0 : 1.0);
  return g.centre_px +
         Vec2{std::cos(angle) * x - std::sin(angle) * y, std::sin(angle) * x + std::cos(angle) * y};
}

const std::vector<CameraGeometry>& geometries() {
  static const std::vector<CameraGeometry> all{
      {0.0, Mirror::none, 1.0, {255.5, 255.5}},   {3.0, Mirror::none, 1.0, {255.5, 255.5}},
      {33.0, Mirror::none, 1.05, {275.5, 235.5}}, {90.0, Mirror::none, 1.0, {255.5, 255.5}},
      {0.0, Mirror::x, 1.0, {255.5, 255.5}},      {-120.0, Mirror::y, 0.95, {235.5, 255.5}},
      {-90.0, Mirror::x, 1.05, {255.5, 275.5}},   {180.0, Mirror::none, 1.0, {255.5, 255.5}},
      {33.0, Mirror::x, 1.0, {255.25, 255.125}},
  };
  return all;
}

std::string text_of(const CameraGeometry& g) {
  return std::to_string(g.rotation_deg) + " degrees, mirror " +
         mirror_names()[std::size_t(g.mirror)];
}

/// Maximum error at `count` random pixels, in units of the field's peak.
double field_error(const CameraGeometry& geometry, const Image<std::uint8_t>& grey, const Roi& roi,
                   int count) {
  const Config config = config_of();
  BenchModel model(config);
  model.set_window(roi, geometry);
  const auto start = std::chrono::steady_clock::now();
  const Image<std::complex<float>>& seen = model.field(grey);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  SlmModel slm(config);
  Image<std::complex<float>> field(1280, 768);
  slm.modulate(grey, 0, grey.height, field);
  std::mt19937 random(17);
  double error = 0.0, peak = 0.0;
  for (const std::complex<float> value : seen.pixels) {
    peak = std::max(peak, double(std::abs(value)));
  }
  for (int i = 0; i < count; ++i) {
    const int c = std::uniform_int_distribution(0, roi.width - 1)(random);
    const int r = std::uniform_int_distribution(0, roi.height - 1)(random);
    const Vec2 cpp = camera_map(config, geometry).frequency({double(roi.x + c), double(roi.y + r)});
    const std::complex<double> truth = direct_sum(field, cpp), got = seen.at(c, r);
    error = std::max(error, std::min(std::abs(got - truth), std::abs(got + truth)));
  }
  std::printf("  %s: %.2e of the peak, %.0f ms\n", text_of(geometry).c_str(), error / peak,
              took.count());
  return error / peak;
}

TEST(CameraMap, TurnsFromXTowardsYAndMirrorsFirst) {
  for (const CameraGeometry& g : geometries()) {
    const CameraMap map = camera_map(config_of(), g);
    for (const Vec2 u : {Vec2{0.0, 0.0}, Vec2{0.03, -0.01}, Vec2{-0.002, 0.05}}) {
      const Vec2 px = map.pixel(map.base_cpp + u);
      EXPECT_LT(norm(px - defined_px(g, u)), 1e-9) << text_of(g);
      EXPECT_LT(norm(map.frequency(px) - map.base_cpp - u), 1e-12) << text_of(g);
    }
  }
  // Rotated by 90 degrees, a shift to the right becomes a shift down.
  EXPECT_EQ(camera_map(config_of(), {90.0}).of_x, (Vec2{0.0, 1.0}));
}

TEST(CameraView, FieldEqualsTheFourierSumHoweverTheCameraStands) {
  HologramConfig shown;
  Image<std::uint8_t> grey;
  HologramRenderer::make(shown)->render(HologramKind::sensor, {}, grey);
  for (const CameraGeometry& g : geometries()) {
    EXPECT_LT(field_error(g, grey, {0, 0, 512, 512}, 200), 1e-4) << text_of(g);
  }
}

TEST(CameraView, FieldEqualsTheFourierSumWhereTheSlmIsAsRoughAsItCanBe) {
  const Image<std::uint8_t> grey = random_greys();
  EXPECT_LT(field_error({45.0}, grey, {100, 30, 96, 200}, 200), 2e-4);
  EXPECT_LT(field_error({90.0}, grey, {100, 30, 96, 200}, 100), 1e-4);
}

TEST(CameraView, AWindowOfMoreThanOnePeriodRepeatsItself) {
  const Image<std::uint8_t> grey = random_greys();
  // 0.1 of the scale: 193 pixels a period.
  EXPECT_LT(field_error({20.0, Mirror::none, 0.1, {255.5, 255.5}}, grey, {0, 0, 256, 512}, 200),
            2e-4);
}

/// Centre of a symmetric spot by an iterated Gaussian-weighted centroid.
Vec2 spot_centre(const Image<float>& light, Vec2 at) {
  constexpr double kWidthPx = 4.0;
  for (int step = 0; step < 50; ++step) {
    Vec2 sum;
    double weight = 0.0;
    for (int y = 0; y < light.height; ++y) {
      for (int x = 0; x < light.width; ++x) {
        const Vec2 d = Vec2{double(x), double(y)} - at;
        const double w =
            light.at(x, y) * std::exp(-(d.x * d.x + d.y * d.y) / (2.0 * kWidthPx * kWidthPx));
        sum = sum + w * d;
        weight += w;
      }
    }
    at = at + (1.5 / weight) * sum;
  }
  return at;
}

/// The base subaperture of a bright-spot sensor alone; a fine grating deflects all other light out
/// of view.
Image<std::uint8_t> one_bright_spot() {
  HologramConfig shown;
  shown.sensor.charge = 0;
  Image<std::uint8_t> grey;
  HologramRenderer::make(shown)->render(HologramKind::sensor, {}, grey);
  for (int y = 0; y < 768; ++y) {
    for (int x = 0; x < 1280; ++x) {
      if (std::hypot(x - 639.5, y - 383.5) > 76.8) {
        grey.at(x, y) = std::uint8_t(128 * ((x + y) % 2));
      }
    }
  }
  return grey;
}

TEST(BenchModel, ATiltMovesTheSpotToWhereTheDefinitionSays) {
  const Image<std::uint8_t> grey = one_bright_spot();
  const std::vector<Mode> tilts{{2, 0.8}, {1, -0.5}};
  // Z2 = 2 x and Z1 = 2 y over the pupil's radius of 384 pixels.
  const Vec2 slope_cpp{2.0 * 0.8 / 384.0, -2.0 * 0.5 / 384.0};
  for (const CameraGeometry& g : geometries()) {
    Config config = config_of(R"({"sensor": {"charge": 0}})");
    config.truth.geometry = g;
    config.truth.aberration = tilts;
    BenchModel model(config);
    model.set_window({176, 160, 160, 192}, g);
    const Vec2 expected = defined_px(g, slope_cpp);
    const Vec2 start = expected - Vec2{176, 160} + Vec2{1.0, -1.0};
    const Vec2 found = spot_centre(model.intensity(grey), start) + Vec2{176, 160};
    EXPECT_LT(norm(found - expected), 0.05) << text_of(g);
    EXPECT_LT(norm(BenchModel(config).true_spots_px(config.truth)[9] - expected), 1e-9)
        << text_of(g);
  }
}

TEST(TwinConfig, GeometryIsReadStrictly) {
  const Config config = config_of(R"({"camera": {"rotation_deg": -3.5, "mirror": "y"},
                                  "optics": {"magnification": 1.05, "centre_px": [10, 20]}})");
  EXPECT_EQ(config.truth.geometry, (CameraGeometry{-3.5, Mirror::y, 1.05, {10.0, 20.0}}));
  EXPECT_EQ(parse_config(R"({"camera": {"mirror": "z"}})").error().field, "camera.mirror");
  EXPECT_EQ(parse_config(R"({"camera": {"rotation_deg": 1e9}})").error().field,
            "camera.rotation_deg");
}

}  // namespace
}  // namespace ovws::twin
