#include "daemon/ovws/study/rejection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/series.hpp"

namespace ovws::study {
namespace {

using test::noise;
using test::times;

constexpr double kPi = std::numbers::pi;

TEST(Rejection, OfNothingIsEmpty) {
  EXPECT_TRUE(rejection({}, {}).empty());
  EXPECT_TRUE(octave_bands({}, {}, {}).empty());
}

TEST(RmsOfARecording, IsThatOfItsFrames) {
  EXPECT_NEAR(rms_waves({times(20000, 0.05), {noise(20000, 1)}}), 1.0, 0.03);
}

/// White noise, with and without a loop that steps at every frame.
class IntegratedNoise : public testing::TestWithParam<LoopLaw> {};

TEST_P(IntegratedNoise, IsRejectedAsTheLawSays) {
  const LoopLaw law = GetParam();
  const int count = 40000;
  ModeSeries open{times(count, 1.0 / law.steps_hz), {}}, closed = open;
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
