/// Refinement against the modes that made the image, and against the Cramer-Rao bound.
#include "core/wavefront/refine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "core/optics/noise.hpp"
#include "core/optics/sensor_field.hpp"
#include "core/optics/sensor_model.hpp"

namespace ovws {
namespace {

constexpr double kPeakE = 500.0;
using Waves = std::vector<double>;

std::vector<int> modes_18() {
  std::vector<int> modes(18);
  std::iota(modes.begin(), modes.end(), 1);
  return modes;
}

std::vector<Mode> modes_of(const Waves& waves) {
  std::vector<Mode> modes;
  for (std::size_t k = 0; k < waves.size(); ++k) modes.push_back({int(k) + 1, waves[k]});
  return modes;
}

class Refine : public testing::Test {
 protected:
  /// Model and refiner of one charge, made once for all tests because that takes a second.
  struct Bench {
    SensorModel model;
    Refiner refiner;
  };
  static Bench& bench(int charge = 1) {
    static std::optional<Bench> benches[2];
    std::optional<Bench>& b = benches[charge];
    SensorConfig sensor;
    sensor.charge = charge;
    if (!b) {
      b.emplace(Bench{SensorModel::make(sensor, {}, {}, 512, 512).value(),
                      Refiner::make(sensor, {}, {}, 512, 512, modes_18()).value()});
    }
    return *b;
  }

  Waves random(double rms) {
    std::normal_distribution<double> normal;
    Waves waves(18);
    double squares = 0.0;
    for (double& w : waves) {
      w = normal(random_);
      squares += w * w;
    }
    for (double& w : waves) w *= rms / std::sqrt(squares);
    return waves;
  }
  static Waves sum(Waves a, const Waves& b) {
    for (std::size_t k = 0; k < a.size(); ++k) a[k] += b[k];
    return a;
  }
  static double squared_error(const Refinement& r, const Waves& truth) {
    double sum = 0.0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      sum += (r.modes[k].waves - truth[k]) * (r.modes[k].waves - truth[k]);
    }
    return sum;
  }
  /// Electrons, with kPeakE at the brightest pixel of the spots. The zeroth order's tail on the
  /// left is brighter, but no spot.
  static Image<float> intensity(SensorModel& model, const Waves& truth) {
    Image<float> image = model.intensity(modes_of(truth)).value();
    float most = 0.0F;
    for (const Vec2 spot : model.spots_px()) {
      for (int y = int(spot.y) - 28; y < int(spot.y) + 28; ++y) {
        most = std::max(most, *std::max_element(image.row(y) + int(spot.x) - 28,
                                                image.row(y) + int(spot.x) + 28));
      }
    }
    for (float& pixel : image.pixels) pixel *= float(kPeakE) / most;
    return image;
  }
  static Image<float> exposed(Image<float> image, double read_noise_e, std::uint64_t seed) {
    Noise noise(seed, 7);
    for (float& pixel : image.pixels) {
      pixel = noise.poisson(pixel) + float(read_noise_e) * noise.normal();
    }
    return image;
  }

  std::mt19937 random_{3};
};

TEST_F(Refine, HalfAWaveWithoutNoiseIsRightToTwoThousandths) {
  const Waves truth = random(0.5);
  const auto image = intensity(bench().model, truth);
  const auto r = bench().refiner.refine(image, {}, sum(truth, random(0.1))).value();
  std::printf("  error %.5f wave, %d iterations, chi2 %.4f\n", std::sqrt(squared_error(r, truth)),
              r.iterations, r.chi2_per_pixel);
  EXPECT_LT(std::sqrt(squared_error(r, truth)), 0.002);
  EXPECT_NEAR(r.peak_e, kPeakE, 0.1 * kPeakE);
  EXPECT_LT(r.chi2_per_pixel, 0.01);
}

TEST_F(Refine, ModesThatLoseTheirSpotsAreRightFromAFlatStart) {
  Waves truth(18, 0.0);
  truth[17 - 1] = 0.3;  // six spots without a core at the rim
  const auto image = intensity(bench().model, truth);
  const auto r = bench().refiner.refine(image, {}, Waves(18, 0.0)).value();
  EXPECT_LT(std::sqrt(squared_error(r, truth)), 0.002);
}

TEST_F(Refine, UnevenIlluminationIsFittedIfAsked) {
  const Waves truth = random(0.1);
  std::vector<double> lit(19);
  double squares = 0.0;
  for (std::size_t i = 0; i < lit.size(); ++i) {
    lit[i] = 1.0 + 0.2 * std::sin(2.0 * double(i));
    squares += lit[i] * lit[i] / 19.0;
  }
  SensorField field = SensorField::make({}, {}, {}, 512, 512).value();
  field.propagate(modes_of(truth), {.amplitudes = lit});
  Image<float> image(512, 512);
  std::transform(field.far().pixels.begin(), field.far().pixels.end(), image.pixels.begin(),
                 [](std::complex<float> value) { return std::norm(value) * 5e-6F; });
  Refiner refiner =
      Refiner::make({}, {}, {}, 512, 512, modes_18(), {.spot_amplitudes = true}).value();
  const auto r = refiner.refine(image, {}, Waves(18, 0.0)).value();
  EXPECT_LT(std::sqrt(squared_error(r, truth)), 0.002);
  ASSERT_EQ(r.amplitudes.size(), 19U);
  for (std::size_t i = 0; i < lit.size(); ++i) {
    EXPECT_NEAR(r.amplitudes[i], lit[i] / std::sqrt(squares), 0.01) << i;
  }
}

struct Case {
  int charge;
  double read_noise_e;
  double bound;  ///< of an independent numpy model, summed over the modes, waves^2
};
class RefineNoise : public Refine, public testing::WithParamInterface<Case> {};

TEST_P(RefineNoise, ReachesTheCramerRaoBound) {
  const Case c = GetParam();
  const Waves truth = random(0.1);
  const auto clean = intensity(bench(c.charge).model, truth);
  constexpr int kDraws = 2;
  double squares = 0.0, bound = 0.0;
  for (int k = 0; k < kDraws; ++k) {
    const auto r = bench(c.charge)
                       .refiner
                       .refine(exposed(clean, c.read_noise_e, std::uint64_t(k)),
                               {1.0, c.read_noise_e}, sum(truth, random(0.05)))
                       .value();
    squares += squared_error(r, truth) / kDraws;
    bound += r.covariance.trace() / kDraws;
    EXPECT_NEAR(r.chi2_per_pixel, 1.0, 0.03);
    EXPECT_NEAR(r.background_e, 0.0, 0.05 * c.read_noise_e);
  }
  std::printf("  charge %d, read noise %.0f e: error^2 %.3g, bound %.3g waves^2\n", c.charge,
              c.read_noise_e, squares, bound);
  EXPECT_LT(squares, 2.0 * bound);
  EXPECT_GT(squares, 0.4 * bound);
  // The numpy model's bound is for a flat wavefront without light outside the subapertures.
  EXPECT_LT(bound, 2.0 * c.bound);
  EXPECT_GT(bound, 0.8 * c.bound);
}
INSTANTIATE_TEST_SUITE_P(Peaks, RefineNoise,
                         testing::Values(Case{1, 5.0, 3.7e-7}, Case{1, 250.0, 1.3e-4},
                                         Case{0, 50.0, 1.9e-5}),
                         [](const auto& about) {
                           return "charge" + std::to_string(about.param.charge) + "_" +
                                  std::to_string(int(about.param.read_noise_e)) + "e";
                         });

TEST_F(Refine, ReadsCameraNumbersAndLeavesOutWhatIsSaturated) {
  Waves truth(18, 0.0);
  truth[4] = 0.1;
  const auto electrons = intensity(bench().model, truth);
  Image<std::uint16_t> dn(512, 512);
  for (std::size_t k = 0; k < dn.pixels.size(); ++k) {
    // Saturates at 4095 DN, about half the peak; the black level is 16 DN, an electron 15 DN.
    dn.pixels[k] = std::uint16_t(std::min(4095.0F, 16.0F + 15.0F * electrons.pixels[k] + 0.5F));
  }
  const RefineCamera camera{1.0 / 15.0, 5.0, 16.0, 4095.0};
  const auto r =
      bench().refiner.refine(view_of(dn, PixelFormat::mono12), camera, Waves(18, 0.0)).value();
  EXPECT_LT(std::sqrt(squared_error(r, truth)), 0.002);
  EXPECT_NEAR(r.peak_e, kPeakE, 0.02 * kPeakE);
}

TEST_F(Refine, WhatCannotBeFittedIsAnErrorThatSaysSo) {
  Refiner& refiner = bench().refiner;
  const Waves flat(18, 0.0);
  const auto field = [&](const Image<float>& image, const RefineCamera& camera,
                         const Waves& start) {
    const auto r = refiner.refine(image, camera, start);
    return r ? std::string() : r.error().field;
  };
  const Image<float> dark(512, 512, 0.0F);
  EXPECT_EQ(field(Image<float>(511, 512), {}, flat), "image");
  EXPECT_EQ(field(dark, {}, flat), "image");
  EXPECT_EQ(field(Image<float>(512, 512, NAN), {}, flat), "image");
  EXPECT_EQ(field(dark, {}, Waves(17, 0.0)), "modes");
  EXPECT_EQ(field(dark, {}, Waves(18, NAN)), "modes");
  EXPECT_EQ(field(dark, {0.0, 5.0}, flat), "camera");
  EXPECT_EQ(Refiner::make({}, {}, {}, 512, 512, {0, 1}).error().field, "modes");
  EXPECT_EQ(Refiner::make({}, {}, {}, 512, 512, {1}, {0.5}).error().field, "refine.box_half");
}

TEST_F(Refine, ATurnedCameraSeesTheSameWavefront) {
  const Waves truth = random(0.3);
  const Image<float> straight = bench().model.intensity(modes_of(truth)).value();
  Image<float> seen(512, 512);
  for (int y = 0; y < 512; ++y) {
    for (int x = 0; x < 512; ++x) seen.at(511 - y, x) = straight.at(x, y) * 5e-6F;
  }
  const double scale = camera_px_per_cycle({}, {});
  OpticsConfig turned;
  turned.registered = PxPerCycle(0.0, -scale, scale, 0.0);
  Refiner refiner = Refiner::make({}, {}, turned, 512, 512, modes_18()).value();
  const auto r = refiner.refine(seen, {}, Waves(18, 0.0));
  ASSERT_TRUE(r) << r.error().reason;
  EXPECT_LT(std::sqrt(squared_error(*r, truth)), 0.002);
}

TEST_F(Refine, EndsSoonWhenToldTo) {
  const std::atomic<bool> stop{true};
  RefineOptions options;
  options.stop = &stop;
  auto refiner = Refiner::make({}, {}, {}, 512, 512, modes_18(), options).value();
  Image<float> intensity = bench().model.intensity({}).value();
  scale(intensity, kPeakE / bench().model.peak_of_spots(intensity, {}));
  const auto refused = refiner.refine(intensity, {}, Waves(18, 0.0));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, Errc::refused);
  EXPECT_NE(refused.error().reason.find("cancelled"), std::string::npos);
}

}  // namespace
}  // namespace ovws
