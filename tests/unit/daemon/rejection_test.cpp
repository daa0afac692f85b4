#include "daemon/ovws/study/rejection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace ovws::study {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<double> times(int count, double step_s) {
  std::vector<double> out;
  for (int k = 0; k < count; ++k) out.push_back(k * step_s);
  return out;
}

std::vector<double> noise(int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> out;
  for (int k = 0; k < count; ++k) out.push_back(normal(random));
  return out;
}

double integral(const Spectrum& spectrum, double from_hz, double to_hz) {
  double sum = 0.0;
  for (std::size_t k = 0; k < spectrum.power_per_hz.size(); ++k) {
    if (spectrum.hz(k) >= from_hz && spectrum.hz(k) < to_hz) {
      sum += spectrum.power_per_hz[k] * spectrum.step_hz;
    }
  }
  return sum;
}

TEST(Resample, IsLinearAndKeepsTheEnds) {
  const auto out = resample({1.0, 2.0, 4.0}, {10.0, 20.0, 0.0}, 0.5, 0.5, 9);
  EXPECT_EQ(out, (std::vector<double>{10.0, 10.0, 15.0, 20.0, 15.0, 10.0, 5.0, 0.0, 0.0}));
  EXPECT_EQ(resample({1.0}, {7.0}, 0.0, 1.0, 2), (std::vector<double>{7.0, 7.0}));
}

TEST(MedianInterval, IsThatOfTheFramesThatCame) {
  EXPECT_NEAR(median_interval_s({0.0, 0.1, 0.2, 0.5, 0.6, 0.7}), 0.1, 1e-12);
}

TEST(SpectrumOfASine, HoldsItsPowerAtItsFrequency) {
  Recording recording{times(1000, 0.1), {{}, {}}};
  for (const double t : recording.times_s) {
    recording.modes_waves[0].push_back(5.0 + 0.3 * std::sin(2.0 * kPi * 1.03 * t));
    recording.modes_waves[1].push_back(0.4 * std::cos(2.0 * kPi * 1.03 * t));
  }
  const Spectrum found = spectrum(recording, 20.0);
  EXPECT_NEAR(found.step_hz, 0.05, 1e-12);
  EXPECT_EQ(found.power_per_hz.size(), 99U);
  const double power = 0.5 * (0.3 * 0.3 + 0.4 * 0.4);
  EXPECT_NEAR(integral(found, 0.9, 1.16), power, 0.01 * power);
  EXPECT_NEAR(integral(found, 0.0, 6.0), power, 0.01 * power);
}

TEST(SpectrumOfNoise, IntegratesToItsVariance) {
  const Recording recording{times(20000, 0.05), {noise(20000, 1)}};
  const Spectrum found = spectrum(recording, 10.0);
  EXPECT_NEAR(integral(found, 0.0, 11.0), 1.0, 0.03);
  EXPECT_NEAR(integral(found, 2.0, 4.0), 0.2, 0.02);  // white noise: 1/10 per hertz
  EXPECT_NEAR(rms_waves(recording), 1.0, 0.03);
}

TEST(SpectrumOfFramesThatAreMissing, IsThatOfAllFramesWhereTheySuffice) {
  std::mt19937 random(5);
  Recording recording{{}, {{}}};
  for (int k = 0; k < 1000; ++k) {
    if (random() % 5 == 0) continue;
    recording.times_s.push_back(0.1 * k);
    recording.modes_waves[0].push_back(std::sin(2.0 * kPi * 0.2 * 0.1 * k));
  }
  EXPECT_NEAR(integral(spectrum(recording, 20.0), 0.0, 0.4), 0.5, 0.01);
}

TEST(SpectrumOfTooLittle, IsEmpty) {
  EXPECT_TRUE(spectrum({times(10, 1.0), {noise(10, 1)}}, 20.0).power_per_hz.empty());
  EXPECT_TRUE(spectrum({times(100, 1.0), {noise(100, 1)}}, 7.0).power_per_hz.empty());
  EXPECT_TRUE(spectrum({{0.0}, {{1.0}}}, 1.0).power_per_hz.empty());
  EXPECT_TRUE(rejection({}, {}).empty());
  EXPECT_TRUE(octave_bands({}, {}, {}).empty());
}

/// White noise, with and without a loop that steps at every frame.
class IntegratedNoise : public testing::TestWithParam<LoopLaw> {};

TEST_P(IntegratedNoise, IsRejectedAsTheLawSays) {
  const LoopLaw law = GetParam();
  const int count = 40000;
  Recording open{times(count, 1.0 / law.steps_hz), {}}, closed = open;
  for (std::uint32_t mode = 0; mode < 4; ++mode) {
    open.modes_waves.push_back(noise(count, mode));
    auto& left = closed.modes_waves.emplace_back();
    double correction = 0.0;
    for (const double there : open.modes_waves.back()) {
      left.push_back(there - correction);
      correction = (1.0 - law.leak) * correction + law.gain * left.back();
    }
  }
  const double segment = 400.0 / law.steps_hz;
  const Spectrum before = spectrum(open, segment), after = spectrum(closed, segment);
  const auto found = rejection(before, after);
  ASSERT_EQ(found.size(), 198U);
  for (const RejectionPoint& point : found) {
    if (point.hz < 0.02 * law.steps_hz) continue;  // there a third of an octave has few points
    EXPECT_NEAR(point.db, integrator_db(point.hz, law), 1.0) << point.hz;
  }
  for (const RejectionBand& band : octave_bands(before, after, law)) {
    if (band.from_hz >= 0.02 * law.steps_hz) {
      EXPECT_NEAR(band.db, band.integrator_db, 0.5) << band.from_hz;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rejection, IntegratedNoise,
                         testing::Values(LoopLaw{0.5, 0.0, 10.0}, LoopLaw{0.2, 0.0, 3.0},
                                         LoopLaw{0.5, 0.1, 10.0}));

TEST(Integrator, ForgetsAtLowFrequenciesAndEndsAtHalfItsRate) {
  const LoopLaw law{0.5, 0.0, 10.0};
  EXPECT_NEAR(integrator_db(0.01, law), 20.0 * std::log10(2.0 * kPi * 0.01 / (0.5 * 10.0)), 0.05);
  EXPECT_NEAR(integrator_db(5.0, law), 20.0 * std::log10(2.0 / 1.5), 1e-9);
  EXPECT_TRUE(std::isnan(integrator_db(5.1, law)));
  EXPECT_NEAR(integrator_db(1e-6, {0.5, 0.1, 10.0}), 20.0 * std::log10(0.1 / 0.6), 1e-3);
}

TEST(Crossing, OfAKnownCurve) {
  std::vector<RejectionPoint> curve;
  for (double hz = 0.1; hz < 10.0; hz *= 1.3) {
    curve.push_back({hz, std::fmin(20.0 * std::log10(hz / 2.0), 2.0)});
  }
  EXPECT_NEAR(*crossing_hz(curve, 0.0), 2.0, 1e-9);
  EXPECT_NEAR(*crossing_hz(curve, -3.0), 2.0 * std::pow(10.0, -0.15), 1e-9);
  EXPECT_FALSE(crossing_hz(curve, 5.0));
  EXPECT_FALSE(crossing_hz(curve, -40.0));
  EXPECT_FALSE(crossing_hz({}, 0.0));
}

TEST(OctaveBands, AreWholeOctavesThatBothReach) {
  const Spectrum open{0.04, std::vector<double>(100, 2.0)},
      closed{0.04, std::vector<double>(50, 1.0)};
  const auto bands = octave_bands(open, closed, {0.5, 0.0, 2.0});
  ASSERT_EQ(bands.size(), 4U);  // from 0.1 to 1.6 Hz: both reach from 0.08 to 2
  EXPECT_DOUBLE_EQ(bands.front().from_hz, 0.1);
  EXPECT_NEAR(bands[1].db, -3.01, 0.01);
  EXPECT_TRUE(std::isnan(bands.back().integrator_db));
}

}  // namespace
}  // namespace ovws::study
