#include <algorithm>

#include "core/control/disturbance.hpp"

#include <gtest/gtest.h>

#include "core/control/forecast.hpp"
#include "core/control/integrator.hpp"
#include "core/control/predictor.hpp"
#include "tests/unit/control/simulated_loop.hpp"

namespace ovws {
namespace {

using test::kFrame;

/// Spectrum of a minute of frames, with noise.
Spectrum spectrum_of(const Disturbance& of) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0.0, of.noise_waves);
  ModeSeries series{{}, {test::samples_of(of, kFrame, 12'000)}};
  for (double& waves : series.modes_waves[0]) {
    series.times_s.push_back(kFrame * double(series.times_s.size()));
    waves += noise(random);
  }
  return spectrum(series, 20.0);
}

TEST(Oscillator, MovesAndKeepsItsPower) {
  const Oscillator line{3.0, 0.1, 2.0};
  double sum = 0.0;
  for (double hz = 0.005; hz < 400.0; hz += 0.01) sum += 0.01 * line.power_per_hz(hz);
  EXPECT_NEAR(sum, 4.0, 0.01);
  const Eigen::Matrix2d twice = line.transition(0.02) * line.transition(0.03);
  EXPECT_TRUE(twice.isApprox(line.transition(0.05), 1e-12));
  EXPECT_TRUE(line.transition(0.0).isApprox(Eigen::Matrix2d::Identity()));
  const Oscillator slow{0.1, 1.0, 1.0};
  EXPECT_NEAR(slow.transition(0.5)(0, 0),
              (1.0 + 0.1 * std::numbers::pi) * std::exp(-0.1 * std::numbers::pi), 1e-9);
}

TEST(Identify, FindsALineInAir) {
  const Disturbance truth{{{0.5, 1.0, 0.05}, {5.0, 0.01, 0.03}}, 0.004};
  const Disturbance found = identify(spectrum_of(truth), kFrame, 0.0035);
  EXPECT_NEAR(found.noise_waves, 0.004, 0.0006);
  EXPECT_NEAR(found.rms_waves(), truth.rms_waves(), 0.3 * truth.rms_waves());
  double line = 0.0;
  for (const Oscillator& part : found.parts) {
    if (part.hz > 4.0 && part.hz < 6.0) line = std::hypot(line, part.rms_waves);
  }
  EXPECT_NEAR(line, 0.03, 0.01);
  EXPECT_LE(found.parts.size(), std::size_t(Disturbance::kMaxParts));
}

TEST(Identify, FindsAWeakLineBesideStrongSlowMotion) {
  const Disturbance truth{{{0.3, 1.0, 0.3}, {20.0, 0.005, 0.004}}, 0.002};
  const Disturbance found = identify(spectrum_of(truth), kFrame, 0.002);
  double line = 0.0;
  for (const Oscillator& part : found.parts) {
    if (part.hz > 19.0 && part.hz < 21.0) line = std::hypot(line, part.rms_waves);
  }
  EXPECT_NEAR(line, 0.004, 0.002);
}

TEST(Identify, OfNoiseAloneFindsLittleElse) {
  const Disturbance found = identify(spectrum_of({{}, 0.01}), kFrame, 0.005);
  EXPECT_NEAR(found.noise_waves, 0.01, 0.002);
  EXPECT_LT(found.rms_waves(), 0.006);
}

TEST(Identify, OfNothingHasNoParts) {
  EXPECT_TRUE(identify({}, kFrame, 0.01).parts.empty());
  EXPECT_NEAR(identify({}, kFrame, 0.01).noise_waves, 0.01, 1e-12);
}

/// A predictor made from what was identified in one minute serves in the next.
TEST(Identify, MakesAPredictorThatIsNearlyAsGoodAsThatOfTheTruth) {
  const Disturbance truth{{{0.5, 1.0, 0.05}, {5.0, 0.01, 0.03}}, 0.004};
  const Disturbance found = identify(spectrum_of(truth), kFrame, 0.004);
  constexpr double kStep = 1.0 / 60.0;
  const auto later = test::samples_of(truth, kStep, 6000, 5);
  Predictor known(truth, 0.0), identified(found, 0.0);
  EXPECT_LT(test::rms_of(test::residuals_of(identified, later, kStep, 0.004)),
            1.2 * test::rms_of(test::residuals_of(known, later, kStep, 0.004)));
}

TEST(Forecast, IsWhatALoopLeaves) {
  constexpr double kStep = 1.0 / 60.0;
  const Disturbance truth{{{0.5, 1.0, 0.05}, {5.0, 0.02, 0.03}}, 0.004};
  const auto waves = test::samples_of(truth, kStep, 40'000);
  for (const test::Delays& delays : {test::Delays{1}, test::Delays{2}}) {
    const LoopTiming timing = test::timing_of(delays, kStep);
    const auto left = [&](ModeLaw&& law, double expected) {
      EXPECT_NEAR(test::rms_of(test::residuals_of(law, waves, kStep, 0.004, delays)), expected,
                  0.1 * expected);
    };
    const LoopForecast slow = forecast(Integrator(0.5, 0.0, 0.0), truth, timing);
    left(Integrator(0.5, 0.0, 0.0), slow.residual_waves);
    EXPECT_NEAR(slow.gain_margin, 1.0, 1e-3);
    const LoopForecast fast = forecast(Predictor(truth, 0.0), truth, timing);
    left(Predictor(truth, 0.0), fast.residual_waves);
    EXPECT_LT(fast.residual_waves, slow.residual_waves);
  }
}

TEST(BestGain, IsHighForSlowAirAndLowForNoise) {
  constexpr double kStep = 1.0 / 60.0;
  EXPECT_GT(best_gain({{{0.3, 1.0, 0.1}}, 0.001}, {kStep, kStep}, 0.0, 0.5), 0.8);
  EXPECT_LT(best_gain({{{0.3, 1.0, 0.002}}, 0.02}, {kStep, kStep}, 0.0, 0.5), 0.1);
}

/// A correction of the wrong size is tolerated up to the gain margin.
TEST(GainMargin, HoldsInALoopWhoseCorrectionIsTooLarge) {
  constexpr double kStep = 1.0 / 60.0;
  constexpr std::int64_t kStepNs = 16'666'667;
  const Disturbance of{{{0.5, 1.0, 0.05}, {5.0, 0.02, 0.03}}, 0.004};
  for (const int delay : {1, 2}) {
    Predictor law(of, 0.0);
    const LoopTiming timing = test::timing_of({delay}, kStep);
    const double larger = 1.0 + 0.9 * forecast(law, of, timing).gain_margin;
    double most = 0.0;
    std::vector<double> shown(std::size_t(delay), 0.0);
    for (std::size_t k = 0; k < 5000; ++k) {
      const std::int64_t t_ns = std::int64_t(k + 1) * kStepNs;
      const double residual = 0.1 - larger * shown[k];
      most = k > 2500 ? std::max(most, std::abs(residual)) : 0.0;
      law.observe({t_ns, residual, 0.004, shown[k]});
      shown.push_back(law.step(t_ns + delay * kStepNs, test::kNoLimit));
    }
    EXPECT_LT(most, 0.1) << delay;
  }
}

}  // namespace
}  // namespace ovws
