/// Vortex path against images that are Fourier sums over the SLM's pixels.
#include "core/wavefront/vortex_path.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <random>

namespace ovws {
namespace {

using Complex = std::complex<double>;
using Amplitude = std::function<double(Vec2)>;  // at a place in pupil radii

constexpr int kImageSide = 41;  // of the images, camera pixels
constexpr Vec2 kMiddle{19.7, 20.4};
const PxPerCycle kTurnedImage(120.0, 215.0, 215.0, -120.0);  // and mirrored
const VortexBeam kBeam{kTurnedImage, 96.0, 1, {}};           // lambda/D = 2.56 px

double uniform(Vec2 /*at*/) {
  return 1.0;
}

/// The field of one SLM pixel, and its place from the pupil's centre.
struct Source {
  Vec2 at_px;
  Complex field;
};

std::vector<Source> sources(const VortexBeam& beam, std::span<const Mode> modes, Vec2 axis,
                            const Amplitude& amplitude = uniform) {
  std::vector<Source> all;
  const double radius = 0.5 * beam.pupil_diameter_px;
  for (double y = 0.5 - radius; y < radius; y += 1.0) {
    for (double x = 0.5 - radius; x < radius; x += 1.0) {
      const Vec2 at{x / radius, y / radius};
      if (norm(at) > 1.0) continue;
      const double vortex = beam.charge * std::atan2(at.y - axis.y, at.x - axis.x);
      const double phase = 2.0 * std::numbers::pi * wavefront(modes, at) + vortex;
      all.push_back({{x, y}, std::polar(amplitude(at), phase)});
    }
  }
  return all;
}

/// Far field at a camera pixel.
Complex field_at(const VortexBeam& beam, const std::vector<Source>& all, Vec2 px) {
  const PxPerCycle& m = beam.px_per_cycle;
  const Vec2 off = px - kMiddle;
  const Vec2 cpp =
      (1.0 / m.determinant()) * Vec2{m.yy * off.x - m.xy * off.y, m.xx * off.y - m.yx * off.x};
  Complex sum = 0.0;
  for (const Source& one : all) {
    const double turns = cpp.x * one.at_px.x + cpp.y * one.at_px.y;
    sum += one.field * std::polar(1.0, -2.0 * std::numbers::pi * turns);
  }
  return sum;
}

/// Images at all axes; the brightest pixel has `peak_dn`, above a background of 2.
std::vector<VortexImage> vortex_images(const VortexBeam& beam, std::span<const Mode> modes,
                                       double peak_dn, const Amplitude& amplitude = uniform) {
  std::vector<VortexImage> images;
  for (const Vec2 axis : vortex_axes()) {
    Image<float> light(kImageSide, kImageSide, 0.0F);
    const auto from = sources(beam, modes, axis, amplitude);
    for (int y = 0; y < kImageSide; ++y) {
      for (int x = 0; x < kImageSide; ++x) {
        if (norm(Vec2{double(x), double(y)} - kMiddle) > 9.5) continue;
        light.at(x, y) = float(std::norm(field_at(beam, from, {double(x), double(y)})));
      }
    }
    const float brightest = *std::ranges::max_element(light.pixels);
    for (float& dn : light.pixels) dn = 2.0F + float(peak_dn) * dn / brightest;
    images.push_back({axis, std::move(light)});
  }
  return images;
}

double mode_waves(std::span<const Mode> modes, int j) {
  const auto found = std::ranges::find(modes, j, &Mode::j);
  return found == modes.end() ? 0.0 : found->waves;
}

/// Largest error of a mode up to coma and of spherical aberration, waves.
double largest_error(const VortexPath& path, std::span<const Mode> truth) {
  double largest = 0.0;
  for (const int j : {3, 4, 5, 7, 8, 12}) {
    largest = std::max(largest, std::abs(mode_waves(path.modes, j) - mode_waves(truth, j)));
  }
  return largest;
}

TEST(VortexPath, FindsThePrimaryAberrationsWithATurnedAndMirroredCamera) {
  for (const double defocus : {-0.1, 0.0, 0.1}) {
    const std::vector<Mode> modes{{3, 0.04}, {4, defocus}, {5, -0.03}, {7, 0.03}, {8, -0.04}};
    const auto path =
        fit_vortex_path(vortex_images(kBeam, modes, 200.0), kBeam, kMiddle + Vec2{0.8, -0.6});
    ASSERT_TRUE(path) << path.error().reason;
    EXPECT_LT(largest_error(*path, modes), 0.002) << defocus;
    EXPECT_LT(norm(path->middle_px - kMiddle), 0.02) << defocus;
    EXPECT_LT(path->motion_px, 0.02) << defocus;
  }
}

TEST(VortexPath, IsNotMisledByUnevenLightAndHigherOrders) {
  const std::vector<Mode> modes{{4, 0.05},  {6, 0.04},  {11, 0.03},
                                {12, 0.04}, {17, 0.03}, {24, 0.03}};
  const auto path = fit_vortex_path(
      vortex_images(kBeam, modes, 200.0,
                    [](Vec2 at) {
                      return (1.0 + 0.2 * at.x) * std::exp(-0.4 * (at.x * at.x + at.y * at.y));
                    }),
      kBeam, kMiddle);
  ASSERT_TRUE(path) << path.error().reason;
  EXPECT_LT(largest_error(*path, modes), 0.005);
}

TEST(VortexPath, HasTheDarkCoresOfTheImages) {
  for (const int charge : {1, -1}) {
    VortexBeam beam = kBeam;
    beam.charge = charge;
    const std::vector<Mode> modes{{4, 0.08}, {8, 0.03}};
    const auto path = fit_vortex_path(vortex_images(beam, modes, 200.0), beam, kMiddle);
    ASSERT_TRUE(path) << path.error().reason;
    EXPECT_LT(largest_error(*path, modes), 0.002) << charge;
    const double bright =
        std::abs(field_at(beam, sources(beam, modes, {}), kMiddle + Vec2{2.5, 0.0}));
    for (std::size_t k = 0; k < vortex_axes().size(); ++k) {
      ASSERT_TRUE(path->cores_px[k]);
      EXPECT_LT(
          std::abs(field_at(beam, sources(beam, modes, vortex_axes()[k]), *path->cores_px[k])),
          0.01 * bright)
          << charge << ' ' << k;
    }
  }
}

/// The paper's statement: in focus a core off the axis moves perpendicular to the shift, and
/// defocus turns its path.
TEST(VortexPath, IsTurnedByDefocusOnly) {
  VortexBeam beam = kBeam;
  beam.px_per_cycle = 246.0;  // camera and SLM aligned
  const Vec2 axis = vortex_axes()[1];
  for (const double defocus : {-0.05, 0.0, 0.05}) {
    const std::vector<Mode> modes{{4, defocus}};
    const auto path = fit_vortex_path(vortex_images(beam, modes, 200.0), beam, kMiddle);
    ASSERT_TRUE(path) << path.error().reason;
    const Vec2 moved = *path->cores_px[1] - kMiddle;
    const double turn =
        std::atan2(axis.x * moved.y - axis.y * moved.x, axis.x * moved.x + axis.y * moved.y);
    EXPECT_NEAR(turn * 180.0 / std::numbers::pi, 90.0 - 18.7 * defocus / 0.05, 1.0);
  }
}

TEST(VortexPath, IsNotMisledByABeamThatMovesBetweenTheImages) {
  const std::vector<Mode> still{{4, 0.05}, {8, -0.03}};
  std::vector<VortexImage> images;
  for (std::size_t k = 0; k < vortex_axes().size(); ++k) {
    std::vector<Mode> modes = still;
    modes.push_back({1, 0.2 * std::sin(2.0 * double(k))});
    modes.push_back({2, 0.2 * std::cos(3.0 * double(k))});
    images.push_back(vortex_images(kBeam, modes, 200.0)[k]);
  }
  const auto path = fit_vortex_path(images, kBeam, kMiddle);
  ASSERT_TRUE(path) << path.error().reason;
  EXPECT_LT(largest_error(*path, still), 0.003);
  EXPECT_NEAR(path->motion_px, 0.2 * 4.0 * 2.56, 0.3);  // a wave of tilt is 4 lambda/D
}

TEST(VortexPath, HasHonestStandardErrors) {
  const std::vector<Mode> modes{{4, 0.03}, {3, 0.02}};
  const auto clean = vortex_images(kBeam, modes, 100.0);
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0F, 3.0F);
  constexpr int kRuns = 24;
  double squares = 0.0;
  int count = 0;
  for (int run = 0; run < kRuns; ++run) {
    auto noisy = clean;
    for (VortexImage& image : noisy) {
      for (float& dn : image.light.pixels) dn += noise(random);
    }
    const auto path = fit_vortex_path(noisy, kBeam, kMiddle);
    ASSERT_TRUE(path) << path.error().reason;
    for (std::size_t k = 0; k < 6; ++k) {  // up to coma
      const double error = path->modes[k].waves - mode_waves(modes, path->modes[k].j);
      squares += error * error / (path->standard_error[k] * path->standard_error[k]);
      ++count;
    }
    EXPECT_LT(path->standard_error[1], 0.01);  // defocus
  }
  EXPECT_NEAR(std::sqrt(squares / count), 1.0, 0.25);
}

TEST(VortexPath, UsesThePixelsThatTheLaserReaches) {
  VortexBeam beam = kBeam;
  beam.lit.plane = {2, 1, 0};
  const std::vector<Mode> modes{{4, -0.06}, {7, 0.03}};
  auto images = vortex_images(beam, modes, 200.0);
  for (VortexImage& image : images) {
    for (int y = 0; y < kImageSide; ++y) {
      for (int x = 0; x < kImageSide; ++x) {
        if (!beam.lit.has(x, y)) image.light.at(x, y) = 77.0F;
      }
    }
  }
  const auto path = fit_vortex_path(images, beam, kMiddle);
  ASSERT_TRUE(path) << path.error().reason;
  EXPECT_LT(largest_error(*path, modes), 0.004);
}

TEST(VortexPath, RefusesImagesWithoutTheVortex) {
  auto images = vortex_images(kBeam, {}, 200.0);
  const auto beside = fit_vortex_path(images, kBeam, {-20.0, 5.0});
  ASSERT_FALSE(beside);
  EXPECT_EQ(beside.error().field, "camera.roi");
  for (VortexImage& image : images) {
    std::ranges::fill(image.light.pixels, 0.0F);
  }
  EXPECT_FALSE(fit_vortex_path(images, kBeam, kMiddle));
}

}  // namespace
}  // namespace ovws
