#include "daemon/ovws/study/rejection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/control/integrator.hpp"
#include "tests/support/series.hpp"
#include "tests/unit/control/simulated_loop.hpp"

namespace ovws::study {
namespace {

using test::noise;
using test::times;

TEST(Rejection, OfNothingIsEmpty) {
  EXPECT_TRUE(rejection({}, {}).empty());
  EXPECT_TRUE(octave_bands({}, {}, {}).empty());
}

TEST(RmsOfARecording, IsThatOfItsFrames) {
  EXPECT_NEAR(rms_waves({times(20000, 0.05), {noise(20000, 1)}}), 1.0, 0.03);
}

struct Case {
  double gain, leak, steps_hz;
  int delay = 1;  ///< steps

  LoopTiming timing() const { return test::timing_of({delay}, 1.0 / steps_hz); }
};

std::vector<std::unique_ptr<ModeLaw>> integrators(const Case& of, int modes) {
  std::vector<std::unique_ptr<ModeLaw>> all;
  for (int k = 0; k < modes; ++k)
    all.push_back(std::make_unique<Integrator>(of.gain, of.leak, 0.0));
  return all;
}

/// White noise, with and without a loop that steps at every frame.
class IntegratedNoise : public testing::TestWithParam<Case> {};

TEST_P(IntegratedNoise, IsRejectedAsTheLawSays) {
  const Case law = GetParam();
  constexpr int kCount = 40000, kModes = 4;
  ModeSeries open{times(kCount, 1.0 / law.steps_hz), {}}, closed = open;
  for (std::uint32_t mode = 0; mode < kModes; ++mode) {
    open.modes_waves.push_back(noise(kCount, mode));
    Integrator integrator(law.gain, law.leak, 0.0);
    closed.modes_waves.push_back(test::residuals_of(integrator, open.modes_waves.back(),
                                                    1.0 / law.steps_hz, 0.0, {law.delay}));
  }
  const double segment = 400.0 / law.steps_hz;
  const Spectrum before = spectrum(open, segment), after = spectrum(closed, segment);
  const Spectrum expected =
      expected_spectrum(open, segment, integrators(law, kModes), law.timing());
  const auto found = rejection(before, after), wanted = rejection(before, expected);
  ASSERT_EQ(found.size(), 198U);
  ASSERT_EQ(wanted.size(), 198U);
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k].hz < 0.02 * law.steps_hz) continue;  // there a third of an octave has few points
    EXPECT_NEAR(found[k].db, wanted[k].db, 1.0) << found[k].hz;
  }
  for (const RejectionBand& band : octave_bands(before, after, expected)) {
    if (band.from_hz >= 0.02 * law.steps_hz) {
      EXPECT_NEAR(band.db, band.expected_db, 0.5) << band.from_hz;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rejection, IntegratedNoise,
                         testing::Values(Case{0.5, 0.0, 10.0}, Case{0.2, 0.0, 3.0},
                                         Case{0.5, 0.1, 10.0}, Case{0.5, 0.0, 10.0, 2}));

TEST(ExpectedSpectrum, EndsAtHalfTheLoopsRate) {
  const ModeSeries open{times(4000, 0.05), {noise(4000, 1)}};
  const Spectrum expected =
      expected_spectrum(open, 20.0, integrators({0.5, 0.0, 10.0}, 1), {0.1, 0.1});
  EXPECT_NEAR(expected.hz(99), 5.0, 1e-9);
  EXPECT_FALSE(std::isnan(expected.power_per_hz[99]));
  EXPECT_TRUE(std::isnan(expected.power_per_hz[100]));
}

/// A bench without disturbance, whose frames have a noise of 1.
TEST(NoiseLimit, IsWhatNoiseAloneLeaves) {
  constexpr int kCount = 40000;
  RejectionMeasured measured;
  measured.modes_j = {4};
  measured.segment_s = 20.0;
  measured.open.recording = {times(kCount, 0.05), {noise(kCount, 1)}};
  MeasuredLaw law;
  law.timing = test::timing_of({2}, 0.05);
  Integrator integrator(law.settings.gain, 0.0, 0.0);
  law.closed = measured.open;
  law.closed.recording.modes_waves = {
      test::residuals_of(integrator, noise(kCount, 2), 0.05, 0.0, {2})};
  measured.laws = {law};
  const RejectionFound found = find_rejection(measured);
  EXPECT_NEAR(found.laws[0].noise_limit_waves, rms_waves(law.closed.recording), 0.03);
  EXPECT_NEAR(found.laws[0].noise_passed_waves, std::sqrt(1.0 / 3.0), 0.02);
  EXPECT_NEAR(found.noise_per_hz, 0.1, 0.005);
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
  Spectrum expected = closed;
  expected.power_per_hz.back() = NAN;
  const auto bands = octave_bands(open, closed, expected);
  ASSERT_EQ(bands.size(), 4U);  // from 0.1 to 1.6 Hz: both reach from 0.08 to 2
  EXPECT_DOUBLE_EQ(bands.front().from_hz, 0.1);
  EXPECT_NEAR(bands[1].db, -3.01, 0.01);
  EXPECT_NEAR(bands[1].expected_db, -3.01, 0.01);
}

}  // namespace
}  // namespace ovws::study
