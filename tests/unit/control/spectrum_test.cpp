#include "core/control/spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/series.hpp"

namespace ovws {
namespace {

using test::noise;
using test::times;

constexpr double kPi = std::numbers::pi;

double integral(const Spectrum& spectrum, double from_hz, double to_hz) {
  double sum = 0.0;
  for (std::size_t k = 0; k < spectrum.power_per_hz.size(); ++k) {
    if (spectrum.hz(k) >= from_hz && spectrum.hz(k) < to_hz) {
      sum += spectrum.power_per_hz[k] * spectrum.step_hz;
    }
  }
  return sum;
}

TEST(Resample, IsLinearInGapsAndKeepsTheEnds) {
  const auto out = resample({1.0, 2.0, 4.0}, {10.0, 20.0, 0.0}, 0.5, 0.5, 9);
  EXPECT_EQ(out, (std::vector<double>{10.0, 10.0, 15.0, 20.0, 15.0, 10.0, 5.0, 0.0, 0.0}));
  EXPECT_EQ(resample({1.0}, {7.0}, 0.0, 1.0, 2), (std::vector<double>{7.0, 7.0}));
  EXPECT_EQ(resample({1.1, 1.9, 3.2}, {1.0, 2.0, 3.0}, 1.0, 1.0, 3),
            (std::vector<double>{1.0, 2.0, 3.0}));
}

TEST(MedianInterval, IsThatOfTheFramesThatCame) {
  EXPECT_NEAR(median_interval_s({0.0, 0.1, 0.2, 0.5, 0.6, 0.7}), 0.1, 1e-12);
}

TEST(SpectrumOfASine, HoldsItsPowerAtItsFrequency) {
  ModeSeries series{times(1000, 0.1), {{}, {}}};
  for (const double t : series.times_s) {
    series.modes_waves[0].push_back(5.0 + 0.3 * std::sin(2.0 * kPi * 1.03 * t));
    series.modes_waves[1].push_back(0.4 * std::cos(2.0 * kPi * 1.03 * t));
  }
  const Spectrum found = spectrum(series, 20.0);
  EXPECT_NEAR(found.step_hz, 0.05, 1e-12);
  EXPECT_EQ(found.power_per_hz.size(), 99U);
  const double power = 0.5 * (0.3 * 0.3 + 0.4 * 0.4);
  EXPECT_NEAR(integral(found, 0.9, 1.16), power, 0.01 * power);
  EXPECT_NEAR(integral(found, 0.0, 6.0), power, 0.01 * power);
}

TEST(SpectrumOfNoise, IntegratesToItsVariance) {
  const ModeSeries series{times(20000, 0.05), {noise(20000, 1)}};
  const Spectrum found = spectrum(series, 10.0);
  EXPECT_NEAR(integral(found, 0.0, 11.0), 1.0, 0.03);
  EXPECT_NEAR(integral(found, 2.0, 4.0), 0.2, 0.02);  // white noise: 1/10 per hertz
}

TEST(SpectrumOfFramesThatAreMissing, IsThatOfAllFramesWhereTheySuffice) {
  std::mt19937 random(5);
  ModeSeries series{{}, {{}}};
  for (int k = 0; k < 1000; ++k) {
    if (random() % 5 == 0) continue;
    series.times_s.push_back(0.1 * k);
    series.modes_waves[0].push_back(std::sin(2.0 * kPi * 0.2 * 0.1 * k));
  }
  EXPECT_NEAR(integral(spectrum(series, 20.0), 0.0, 0.4), 0.5, 0.01);
}

TEST(SpectrumOfTooLittle, IsEmpty) {
  EXPECT_TRUE(spectrum({times(10, 1.0), {noise(10, 1)}}, 20.0).power_per_hz.empty());
  EXPECT_TRUE(spectrum({times(100, 1.0), {noise(100, 1)}}, 7.0).power_per_hz.empty());
  EXPECT_TRUE(spectrum({{0.0}, {{1.0}}}, 1.0).power_per_hz.empty());
}

}  // namespace
}  // namespace ovws
