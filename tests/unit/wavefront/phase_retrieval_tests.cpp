/// Phase retrieval against far fields of a surface on the SLM's pixels.
#include "core/wavefront/phase_retrieval.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "core/optics/far_field.hpp"
#include "core/optics/flatness.hpp"

namespace ovws {
namespace {

constexpr int kPupilSide = 192, kCells = 48;
constexpr double kScale = 2.6 * kPupilSide;  // camera pixels per cycle per SLM pixel
constexpr double kBrightestElectrons = 8000.0;

/// Waves at a point, pupil radii: two gratings of 4 and 7 periods over the pupil, and coma.
double smooth_surface(Vec2 at) {
  return 0.15 * std::cos(2.0 * std::numbers::pi * (2.0 * at.x + 0.3)) +
         0.1 * std::cos(2.0 * std::numbers::pi * (2.1 * at.x - 2.8 * at.y)) + 0.1 * zernike(8, at);
}

using PupilSurface = std::function<double(Vec2)>;

Image<float> image_of(const std::vector<Mode>& modes, int pixels, const PupilSurface& surface) {
  Image<std::complex<float>> field(kPupilSide, kPupilSide), far;
  for (int k = 0; k < kPupilSide * kPupilSide; ++k) {
    const Vec2 at = cell_centre(kPupilSide, k);
    if (norm(at) > 1.0) continue;
    double waves = surface(at);
    for (const Mode& mode : modes) waves += mode.waves * zernike(mode.j, at);
    const double gaussian = std::exp(-0.4 * (at.x * at.x + at.y * at.y));
    field.at(k % kPupilSide, k / kPupilSide) =
        std::complex<float>(std::polar(gaussian, 2.0 * std::numbers::pi * waves));
  }
  const double first = -0.5 * (pixels - 1) / kScale;
  FarField({kPupilSide, kPupilSide, 19.0}, {pixels, pixels, {first, first}, 1.0 / kScale})
      .propagate(field, far);
  Image<float> image(pixels, pixels);
  for (std::size_t k = 0; k < far.pixels.size(); ++k) image.pixels[k] = std::norm(far.pixels[k]);
  return image;
}

/// What an 8-bit camera of 10,000 electrons sees, minus its black level.
void expose(Image<float>& image, float brightest, std::mt19937& random) {
  for (float& value : image.pixels) {
    const double electrons = kBrightestElectrons * double(value / brightest);
    std::normal_distribution<double> noise(electrons, std::sqrt(electrons + 25.0));
    value = float(std::clamp(std::round(0.0255 * noise(random) + 2.0), 0.0, 255.0) - 2.0);
  }
}

std::vector<DiverseImage> diverse_images(const PhaseRetrieval& retrieval, unsigned seed,
                                         const PupilSurface& surface = smooth_surface) {
  std::vector<DiverseImage> images;
  for (const auto& modes : diversity_patterns(6, kCells)) {
    images.push_back({modes, image_of(modes, retrieval.window_px(), surface)});
  }
  float brightest = 0.0F;
  for (const auto& one : images) {
    brightest = std::max(brightest, *std::ranges::max_element(one.intensity.pixels));
  }
  std::mt19937 random(seed);
  for (auto& one : images) expose(one.intensity, brightest, random);
  return images;
}

Image<float> true_waves() {
  Image<float> waves(kCells, kCells);
  for (int k = 0; k < kCells * kCells; ++k) {
    const Vec2 at = cell_centre(kCells, k);
    waves.pixels[std::size_t(k)] =
        norm(at) > 1.0 ? std::numeric_limits<float>::quiet_NaN() : float(smooth_surface(at));
  }
  remove_tilts(waves);
  return waves;
}

double error_of(Image<float> found) {
  const Image<float> real = true_waves();
  for (std::size_t k = 0; k < found.pixels.size(); ++k) found.pixels[k] -= real.pixels[k];
  return rms_of(found);
}

std::vector<DiverseImage> mirrored(std::vector<DiverseImage> images) {
  for (auto& one : images) {
    const Image<float> before = one.intensity;
    for (int y = 0; y < before.height; ++y) {
      for (int x = 0; x < before.width; ++x) one.intensity.at(x, y) = before.at(y, x);
    }
  }
  return images;
}

const auto kGoOn = [] { return false; };

TEST(PhaseRetrieval, FindsAFineSurfaceFromNoisy8BitImages) {
  const auto retrieval = PhaseRetrieval::make(kScale, kPupilSide, kCells);
  ASSERT_TRUE(retrieval);
  const auto one = retrieval->retrieve(diverse_images(*retrieval, 1), false, kGoOn);
  const auto other = retrieval->retrieve(diverse_images(*retrieval, 2), false, kGoOn);
  ASSERT_TRUE(one && other);
  EXPECT_FALSE(one->singularity || other->singularity);
  EXPECT_GT(rms_of(true_waves()), 0.15);
  EXPECT_LT(error_of(one->waves), 0.012);
  EXPECT_LT(one->misfit, 0.1);
  // The surface has no structure finer than 7 periods over the pupil.
  const double resolution = common_resolution(one->waves, other->waves);
  EXPECT_LE(resolution, 0.5 * kCells / 7.0);
  EXPECT_GE(resolution, 1.0);
}

TEST(PhaseRetrieval, MirroredCameraAndUnknownPixels) {
  const auto retrieval = PhaseRetrieval::make({0.0, kScale, kScale, 0.0}, kPupilSide, kCells);
  ASSERT_TRUE(retrieval);
  auto images = mirrored(diverse_images(*retrieval, 1));
  for (auto& one : images) {
    for (int k = 0; k < 10; ++k) {
      one.intensity.at(20 + k, 30) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  const auto found = retrieval->retrieve(images, false, kGoOn);
  ASSERT_TRUE(found);
  EXPECT_LT(error_of(found->waves), 0.012);
}

TEST(PhaseRetrieval, ImagesOfNothingLeaveALargeMisfitOrJumps) {
  const auto retrieval = PhaseRetrieval::make(kScale, kPupilSide, kCells);
  ASSERT_TRUE(retrieval);
  auto images = diverse_images(*retrieval, 1);
  std::ranges::rotate(images[0].intensity.pixels,
                      images[0].intensity.pixels.begin() + 40 * retrieval->window_px());
  std::swap(images[1].intensity, images[4].intensity);
  const auto found = retrieval->retrieve(images, true, kGoOn);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->singularity || found->misfit > 0.2) << found->misfit;
}

/// Also of light that is flat otherwise, whose images hardly differ from those without a vortex.
TEST(PhaseRetrieval, FindsThePlaceOfAVortex) {
  const auto retrieval = PhaseRetrieval::make({0.0, kScale, kScale, 0.0}, kPupilSide, kCells);
  ASSERT_TRUE(retrieval);
  for (const double rough : {0.0, 1.0}) {
    for (const Vec2 place : {Vec2{0.0, 0.05}, Vec2{0.3, -0.6}, Vec2{-0.9, 0.1}}) {
      const auto images = diverse_images(*retrieval, 1, [&](Vec2 at) {
        const Vec2 from = at - place;
        return rough * smooth_surface(at) + std::atan2(from.y, from.x) / (2.0 * std::numbers::pi);
      });
      const auto found = retrieval->retrieve(mirrored(images), rough == 0.0, kGoOn);
      ASSERT_TRUE(found && found->singularity) << rough << ": " << place.x << ", " << place.y;
      EXPECT_LT(norm(*found->singularity - place), 0.08);
      EXPECT_LT(found->misfit, 0.1);
    }
  }
}

TEST(PhaseRetrieval, TooCoarseAFarFieldAndAStop) {
  EXPECT_EQ(PhaseRetrieval::make(1.9 * kPupilSide, kPupilSide, kCells).error().field, "optics");
  const auto retrieval = PhaseRetrieval::make(kScale, kPupilSide, kCells);
  EXPECT_FALSE(retrieval->retrieve(diverse_images(*retrieval, 1), true, [] { return true; }));
}

}  // namespace
}  // namespace ovws
