/// Each stage of the detector against its own theory.
#include "core/optics/detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ovws {
namespace {

constexpr int kSize = 400;
constexpr double kPixels = kSize * kSize;

/// Nothing but quantum efficiency 1, one DN per electron and quantisation to 16 bits.
DetectorConfig ideal() {
  DetectorConfig config;
  config.quantum_efficiency = 1.0;
  config.prnu = 0.0;
  config.shot_noise = false;
  config.dark_current_e_per_s = 0.0;
  config.read_noise_e = 0.0;
  config.full_well_e = 65535.0;
  config.black_level_dn = 0.0;
  config.bits = 16;
  return config;
}

Image<std::uint16_t> exposed(const DetectorConfig& config, float photons, double gain_db = 0.0,
                             double exposure_us = 1000.0) {
  Detector detector(config, kSize, kSize);
  Image<std::uint16_t> dn;
  detector.expose(Image<float>(kSize, kSize, photons), exposure_us, gain_db, dn);
  return dn;
}

struct Statistics {
  double mean = 0.0;
  double variance = 0.0;
};
Statistics statistics_of(const Image<std::uint16_t>& dn) {
  double sum = 0.0;
  double squares = 0.0;
  for (const std::uint16_t v : dn.pixels) {
    sum += v;
    squares += static_cast<double>(v) * v;
  }
  const double mean = sum / kPixels;
  return {mean, squares / kPixels - mean * mean};
}

/// Five standard errors of a mean and of a variance over the picture.
void expect_statistics(const Image<std::uint16_t>& dn, double mean, double variance) {
  const Statistics found = statistics_of(dn);
  EXPECT_NEAR(found.mean, mean, 5.0 * std::sqrt(variance / kPixels));
  EXPECT_NEAR(found.variance, variance, 5.0 * variance * std::sqrt(2.0 / kPixels) + 0.01);
}

TEST(Detector, WithoutNoiseCountsPhotonsTimesEfficiency) {
  DetectorConfig config = ideal();
  config.quantum_efficiency = 0.6;
  expect_statistics(exposed(config, 1000.0F), 600.0, 0.0);
}

TEST(Detector, PhotonTransferCurveHasTheSlopeOfTheGainAndTheFloorOfTheReadNoise) {
  DetectorConfig config = ideal();
  config.quantum_efficiency = 0.5;
  config.shot_noise = true;
  config.read_noise_e = 12.0;
  config.full_well_e = 10000.0;
  config.black_level_dn = 500.0;
  const double k = dn_per_electron(config, 0.0);
  EXPECT_NEAR(k, 6.5535, 1e-12);
  for (const float photons : {0.0F, 4.0F, 40.0F, 59.0F, 61.0F, 400.0F, 12000.0F}) {
    const double electrons = 0.5 * static_cast<double>(photons);
    expect_statistics(exposed(config, photons), k * electrons + 500.0,
                      k * k * (electrons + 144.0) + 1.0 / 12.0);
  }
}

TEST(Detector, PhotoResponseIsAFixedPattern) {
  DetectorConfig config = ideal();
  config.prnu = 0.02;
  Detector detector(config, kSize, kSize);
  const Image<float> light(kSize, kSize, 20000.0F);
  Image<std::uint16_t> first;
  Image<std::uint16_t> second;
  detector.expose(light, 1000.0, 0.0, first);
  detector.expose(light, 1000.0, 0.0, second);
  EXPECT_EQ(first.pixels, second.pixels);
  expect_statistics(first, 20000.0, 400.0 * 400.0);
  config.seed = 2;
  EXPECT_NE(exposed(config, 20000.0F).pixels, first.pixels);
}

TEST(Detector, DarkSignalGrowsWithExposureAndIsCountedLikeLight) {
  DetectorConfig config = ideal();
  config.dark_current_e_per_s = 50.0;
  expect_statistics(exposed(config, 100.0F, 0.0, 2e6), 200.0, 0.0);
  config.shot_noise = true;
  expect_statistics(exposed(config, 100.0F, 0.0, 2e6), 200.0, 200.0 + 1.0 / 12.0);
  expect_statistics(exposed(config, 100.0F, 0.0, 0.0), 100.0, 100.0 + 1.0 / 12.0);
}

TEST(Detector, FullWellSaturatesBeforeReadNoise) {
  DetectorConfig config = ideal();
  config.full_well_e = 1000.0;
  config.bits = 12;
  for (const std::uint16_t v : exposed(config, 5000.0F).pixels) ASSERT_EQ(v, 4095);
  // At -20 dB the full well is far from the top: the read noise on it is seen, the light is not.
  config.read_noise_e = 30.0;
  config.shot_noise = true;
  const double k = dn_per_electron(config, -20.0);
  expect_statistics(exposed(config, 5000.0F, -20.0), 409.5, k * k * 900.0 + 1.0 / 12.0);
}

TEST(Detector, GainIsTwentyLogTenOfTheAmplitude) {
  const DetectorConfig config = ideal();
  expect_statistics(exposed(config, 100.0F, 20.0), 1000.0, 0.0);
  expect_statistics(exposed(config, 1000.0F, -6.0206), 500.0, 0.0);
  EXPECT_NEAR(dn_per_electron(config, 12.0), std::pow(10.0, 0.6), 1e-12);
}

TEST(Detector, GainScalesReadNoiseAndNotTheBlackLevel) {
  DetectorConfig config = ideal();
  config.read_noise_e = 5.0;
  config.black_level_dn = 300.0;
  expect_statistics(exposed(config, 0.0F, 20.0), 300.0, 50.0 * 50.0 + 1.0 / 12.0);
}

TEST(Detector, QuantisesToTheNearestAndClipsAtBothEnds) {
  for (const int bits : {8, 10, 12}) {
    DetectorConfig config = ideal();
    config.bits = bits;
    config.full_well_e = 10000.0;
    config.black_level_dn = 2.0;
    Detector detector(config, 110, 1);
    Image<float> light(110, 1);
    for (int i = 0; i < 110; ++i) light.at(i, 0) = 100.0F * static_cast<float>(i) + 3.0F;
    Image<std::uint16_t> dn;
    detector.expose(light, 1000.0, 0.0, dn);
    const int top = (1 << bits) - 1;
    for (int i = 0; i < 110; ++i) {
      const double level = std::min(10000.0, 100.0 * i + 3.0) * top / 10000.0 + 2.0;
      EXPECT_EQ(dn.at(i, 0), std::min(top, static_cast<int>(std::lround(level)))) << bits;
    }
  }
  DetectorConfig config = ideal();
  config.black_level_dn = -50.0;
  for (const std::uint16_t v : exposed(config, 20.0F).pixels) ASSERT_EQ(v, 0);
}

TEST(Detector, SameSeedGivesTheSameSequenceOfDifferentImages) {
  const auto sequence = [](std::uint64_t seed) {
    DetectorConfig config;
    config.seed = seed;
    Detector detector(config, kSize, kSize);
    std::vector<Image<std::uint16_t>> pictures(3);
    for (auto& picture : pictures) {
      detector.expose(Image<float>(kSize, kSize, 2000.0F), 1000.0, 0.0, picture);
    }
    return pictures;
  };
  const auto a = sequence(7);
  const auto b = sequence(7);
  const auto c = sequence(8);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(a[i].pixels, b[i].pixels);
    EXPECT_NE(a[i].pixels, c[i].pixels);
  }
  EXPECT_NE(a[0].pixels, a[1].pixels);
  EXPECT_NE(a[1].pixels, a[2].pixels);
}

TEST(Detector, NoiseOfSuccessiveImagesIsIndependent) {
  DetectorConfig config = ideal();
  config.read_noise_e = 100.0;
  config.black_level_dn = 1000.0;
  Detector detector(config, kSize, kSize);
  Image<std::uint16_t> a;
  Image<std::uint16_t> b;
  detector.expose(Image<float>(kSize, kSize), 1000.0, 0.0, a);
  detector.expose(Image<float>(kSize, kSize), 1000.0, 0.0, b);
  double covariance = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    covariance += (a.pixels[i] - 1000.0) * (b.pixels[i] - 1000.0) / kPixels;
  }
  EXPECT_NEAR(covariance / 1e4, 0.0, 5.0 / std::sqrt(kPixels));
}

TEST(Detector, TreatsNegativeAndNanLightAsDarkness) {
  DetectorConfig config = ideal();
  config.shot_noise = true;
  for (const float none : {-5.0F, std::numeric_limits<float>::quiet_NaN()}) {
    for (const std::uint16_t v : exposed(config, none).pixels) ASSERT_EQ(v, 0);
  }
  for (const std::uint16_t v : exposed(config, std::numeric_limits<float>::infinity()).pixels) {
    ASSERT_EQ(v, 65535);
  }
}

}  // namespace
}  // namespace ovws
