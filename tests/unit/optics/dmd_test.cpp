/// Binary holograms of a DMD: which mirrors are on, and the light in their diffraction orders.
#include "core/optics/dmd.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "tests/unit/optics/rendered.hpp"

namespace ovws {
namespace {

using test::rendered;

HologramConfig with(DmdConfig dmd) {
  HologramConfig config;
  config.dmd = std::move(dmd);
  return config;
}

/// Whether a pixel lies in subaperture `s` of the default sensor, less than `radii` from its
/// centre.
bool inside(const Subaperture& s, int x, int y, double radii = 1.0) {
  return norm(Vec2{x - 639.5, y - 383.5} - s.centre_px) <= radii * 76.8;
}

/// Amplitude of the order `m` of subaperture `i`: mean of the mirrors times the conjugate of m
/// times its phase (grating and vortex).
double order_of(const Image<std::uint8_t>& grey, const Lattice& lattice, std::size_t i, int m,
                double radii = 1.0) {
  const Subaperture& s = lattice.subapertures[i];
  std::complex<double> sum;
  double count = 0.0;
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      if (!inside(s, x, y, radii)) continue;
      const Vec2 at{x - 639.5, y - 383.5}, from = at - s.centre_px;
      const double waves = s.frequency_cpp.x * at.x + s.frequency_cpp.y * at.y +
                           s.charge * std::atan2(from.y, from.x) / (2.0 * std::numbers::pi);
      sum += grey.at(x, y) / 255.0 * std::polar(1.0, -2.0 * std::numbers::pi * m * waves);
      ++count;
    }
  }
  return std::abs(sum) / count;
}

TEST(Dmd, MirrorsAreOnWhereThePhaseIsWithinAQuarterWaveOfZero) {
  const std::vector<Mode> modes{{4, 0.4}, {7, -0.2}};
  const auto slm = rendered({}, HologramKind::sensor, modes);
  const auto dmd = rendered(with({}), HologramKind::sensor, modes);
  const Lattice lattice = HologramRenderer::make({}).value().lattice();
  int wrong = 0, on = 0, total = 0;
  for (int y = 0; y < dmd.height; ++y) {
    for (int x = 0; x < dmd.width; ++x) {
      bool lit = false;
      for (const Subaperture& s : lattice.subapertures) lit = lit || inside(s, x, y);
      const int step = slm.at(x, y);     // of the linear LUT: 256 steps a wave
      if (lit && step == 192) continue;  // contains the limit
      wrong += dmd.at(x, y) != (lit && (step < 64 || step > 192) ? 255 : 0);
      on += dmd.at(x, y) == 255;
      total += lit;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_NEAR(double(on) / total, 0.5, 0.01);
}

TEST(Dmd, TheFirstOrderHasTheAmplitudeOfTheDuty) {
  const auto renderer = HologramRenderer::make(with({})).value();
  const auto grey = rendered(with({}), HologramKind::sensor);
  for (const std::size_t i : {0U, 9U, 18U}) {
    EXPECT_NEAR(order_of(grey, renderer.lattice(), i, 1), 1.0 / std::numbers::pi, 0.004) << i;
    EXPECT_NEAR(order_of(grey, renderer.lattice(), i, 0), 0.5, 0.004) << i;
    EXPECT_NEAR(order_of(grey, renderer.lattice(), i, 2), 0.0, 0.01) << i;
  }
}

TEST(Dmd, EachSubapertureHasItsAmplitude) {
  DmdConfig dmd;
  for (int i = 0; i < 19; ++i) dmd.amplitudes.push_back(0.1 + 0.05 * i);
  const auto config = with(dmd);
  const auto renderer = HologramRenderer::make(config).value();
  const auto grey = rendered(config, HologramKind::sensor);
  for (std::size_t i = 0; i < 19; i += 3) {
    const double amplitude = order_of(grey, renderer.lattice(), i, 1) * std::numbers::pi;
    EXPECT_NEAR(amplitude, dmd.amplitudes[i], 0.02) << i;
  }
}

TEST(Dmd, ApodisationLowersTheAmplitudeTowardsTheRim) {
  DmdConfig dmd;
  dmd.apodisation = 0.8;
  const auto config = with(dmd);
  const auto renderer = HologramRenderer::make(config).value();
  const auto grey = rendered(config, HologramKind::sensor);
  // Means of 1 - 0.8 r^2 over the whole disc and over its middle.
  EXPECT_NEAR(order_of(grey, renderer.lattice(), 9, 1) * std::numbers::pi, 0.6, 0.015);
  EXPECT_NEAR(order_of(grey, renderer.lattice(), 9, 1, 0.5) * std::numbers::pi, 0.9, 0.02);
}

TEST(Dmd, APatternIsABitOfAColour) {
  Image<std::uint8_t> mirrors(2, 1), rgb(6, 1);
  mirrors.pixels = {255, 127};
  struct Case {
    BitOrder order;
    int slot, byte;
  };
  for (const auto& [order, slot, byte] :
       {Case{BitOrder::grb, 0, 1}, Case{BitOrder::grb, 9, 0}, Case{BitOrder::grb, 23, 2},
        Case{BitOrder::rgb, 7, 0}, Case{BitOrder::rgb, 8, 1}, Case{BitOrder::bgr, 1, 2}}) {
    std::fill(rgb.pixels.begin(), rgb.pixels.end(), std::uint8_t(0));
    add_pattern(mirrors, slot, order, rgb);
    std::vector<std::uint8_t> expected(6, 0);
    expected[std::size_t(byte)] = std::uint8_t(1U << slot % 8);
    EXPECT_EQ(rgb.pixels, expected) << "slot " << slot;
  }
  add_pattern(mirrors, 2, BitOrder::bgr, rgb);
  EXPECT_EQ(rgb.at(2, 0), 0b110);  // bits are added to those that are there
}

TEST(Dmd, AProbeLightsItsSubapertureOnly) {
  const auto renderer = HologramRenderer::make(with({})).value();
  const Subaperture s = renderer.lattice().subapertures[9];
  Image<std::uint8_t> grey;
  renderer.render_probe({.frequency_cpp = s.frequency_cpp, .charge = 1, .centre_px = s.centre_px},
                        grey);
  EXPECT_GT(order_of(grey, renderer.lattice(), 9, 1), 0.1);
  EXPECT_EQ(grey.at(0, 0), 0);
}

TEST(Dmd, OtherPatternsUseTheWholeDevice) {
  const auto flat = rendered(with({}), HologramKind::flat);
  EXPECT_EQ(flat.at(0, 0), 255);
  EXPECT_EQ(flat.at(640, 384), 255);
  const auto grating = rendered(with({}), HologramKind::grating);
  EXPECT_EQ(grating.at(0, 0), 0);
  Picture picture{Image<float>(1280, 768, 0.5F)};
  picture.waves.at(3, 2) = 0.2F;
  Image<std::uint8_t> grey;
  const auto renderer = HologramRenderer::make(with({})).value();
  renderer.render_picture(picture, grey);
  EXPECT_EQ(grey.at(3, 2), 255);
  EXPECT_EQ(grey.at(4, 2), 0);
  picture.lut = false;  // grey levels as they are: from 128 on
  renderer.render_picture(picture, grey);
  EXPECT_EQ(grey.at(3, 2), 0);
  EXPECT_EQ(grey.at(4, 2), 255);
}

/// The field of make()'s error.
std::string refused(const HologramConfig& config) {
  const auto made = HologramRenderer::make(config);
  return made ? "" : made.error().field;
}

TEST(Dmd, RefusesWrongAmplitudesAndOrdersOnSpots) {
  EXPECT_EQ(refused(with({0.0, {1.0, 0.5}})), "dmd.amplitudes");
  EXPECT_EQ(refused(with({})), "");
  EXPECT_EQ(refused(with({0.5, {}})), "");
  HologramConfig config = with({});
  config.sensor.grooves = {75.0, 0.0};  // a spot meets the zeroth order
  EXPECT_EQ(refused(config), "sensor.grooves");
  config.sensor.grooves = {560.0, 0.0};  // the order -1 comes back by the mirrors' pitch
  EXPECT_EQ(refused(config), "sensor.grooves");
  config.sensor.grooves = {240.0, 0.0};
  EXPECT_EQ(refused(config), "sensor.grooves");  // order -3
  config.sensor.grooves = {180.0, 0.0};
  EXPECT_EQ(refused(config), "");
  config.dmd->apodisation = 0.5;  // now even orders count
  EXPECT_EQ(refused(config), "sensor.grooves");
  config.dmd.reset();
  EXPECT_EQ(refused(config), "");
}

}  // namespace
}  // namespace ovws
