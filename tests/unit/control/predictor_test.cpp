#include "core/control/predictor.hpp"

#include <gtest/gtest.h>

#include "core/control/forecast.hpp"
#include "core/control/integrator.hpp"
#include "tests/unit/control/simulated_loop.hpp"

namespace ovws {
namespace {

using test::kStep;

Disturbance air(double noise_waves) {
  return {{{0.5, 1.0, 0.05}, {1.5, 0.3, 0.02}}, noise_waves};
}

Disturbance air_and_line(double noise_waves) {
  Disturbance all = air(noise_waves);
  all.parts.push_back({5.0, 0.01, 0.05});
  return all;
}

TEST(Predictor, LeavesOfASineWhatItsTransferFunctionSays) {
  for (const Disturbance& of : {air(0.005), air_and_line(0.01)}) {
    test::expect_leaves_what_transfer_says([&] { return Predictor(of, 0.0); }, kStep, 0.01);
  }
}

TEST(Predictor, LeavesLessThanTheBestIntegrator) {
  for (const Disturbance& of : {air(0.002), air(0.01), air_and_line(0.002), air_and_line(0.01)}) {
    const auto waves = test::samples_of(of, kStep, 20'000);
    for (const test::Delays& delays : {test::Delays{1}, test::Delays{2}}) {
      const LoopTiming timing = test::timing_of(delays, kStep);
      Predictor predictor(of, 0.0);
      Integrator integrator(best_gain(of, timing, 0.0, 0.5), 0.0, 0.0);
      const auto left = [&](ModeLaw& law) {
        return test::rms_of(test::residuals_of(law, waves, kStep, of.noise_waves, delays));
      };
      EXPECT_LT(left(predictor), 0.95 * left(integrator))
          << of.parts.size() << " parts, " << of.noise_waves << ", " << timing.delay_s << " s";
    }
  }
}

TEST(Predictor, ReducesAVibrationByTenDecibels) {
  const Disturbance of = air_and_line(0.002);
  const auto waves = test::samples_of({{of.parts.back()}, 0.0}, kStep, 20'000);
  Predictor law(of, 0.0);
  EXPECT_LT(test::rms_of(test::residuals_of(law, waves, kStep, of.noise_waves)),
            std::pow(10.0, -0.5) * test::rms_of(waves));
}

TEST(Predictor, CorrectsAConstantDisturbanceCompletely) {
  Predictor law(air(0.002), 0.0);
  const auto left = test::residuals_of(law, std::vector<double>(3000, 0.7), kStep);
  EXPECT_LT(std::abs(left.back()), 1e-3);
}

TEST(Predictor, FollowsAJumpWithinAFewSteps) {
  std::vector<double> waves(600, 0.01);
  waves.resize(630, 0.8);
  Predictor law(air_and_line(0.002), 0.0);
  const auto left = test::residuals_of(law, waves, kStep, 0.002);
  EXPECT_NEAR(left[600], 0.79, 0.02);
  EXPECT_LT(std::abs(left[605]), 0.05);
  EXPECT_LT(std::abs(left[625]), 0.02);
}

/// Samples that are missing, and a correction that is shown late, cost no more than the prediction
/// over that time must.
TEST(Predictor, AllowsForMissingSamplesByTheirTimes) {
  const Disturbance line{{{1.0, 0.001, 0.1}}, 0.001};
  const auto waves = test::samples_of(line, kStep, 4000);
  Predictor law(line, 0.0);
  std::mt19937 random(3);
  double shown = 0.0;
  std::vector<double> left;
  for (std::size_t k = 0; k < waves.size(); ++k) {
    const std::int64_t t_ns = 1 + std::llround(1e9 * kStep * double(k));
    left.push_back(waves[k] - shown);
    if (random() % 3 == 0) continue;  // the hologram stays, too
    law.observe({t_ns, waves[k] - shown, 0.001, shown});
    shown = law.step(t_ns + std::llround(1e9 * kStep), test::kNoLimit);
  }
  EXPECT_LT(test::rms_of(std::span(left).last(3000)), 0.1 * test::rms_of(waves));
}

TEST(Predictor, KeepsTheCorrectionUntilTheFirstSample) {
  EXPECT_EQ(Predictor(air(0.002), 0.3).step(5, test::kNoLimit), 0.3);
}

/// Only the slow drift lasts over a minute; the next sample is taken as it is.
TEST(Predictor, ForgetsOverALongGap) {
  Predictor law(air_and_line(0.002), 0.0);
  std::int64_t t_ns = 1;
  for (int k = 0; k < 600; ++k) law.observe({t_ns += 16'000'000, 0.5, 0.002, 0.0});
  EXPECT_NEAR(law.step(t_ns + 16'000'000, test::kNoLimit), 0.5, 0.01);
  const double later = law.step(t_ns += 60'000'000'000, test::kNoLimit);
  EXPECT_GT(later, 0.1);
  EXPECT_LT(later, 0.4);
  law.observe({t_ns, -0.2, 0.002, 0.0});
  EXPECT_NEAR(law.step(t_ns, test::kNoLimit), -0.2, 0.01);
}

TEST(Predictor, SkipsASingleFrameThatIsWrong) {
  Predictor law(air_and_line(0.002), 0.0);
  std::int64_t t_ns = 1;
  for (int k = 0; k < 300; ++k) law.observe({t_ns += 16'000'000, 0.01, 0.002, 0.0});
  const double before = law.step(t_ns + 16'000'000, test::kNoLimit);
  law.observe({t_ns += 16'000'000, 0.8, 0.002, 0.0});
  EXPECT_NEAR(law.step(t_ns, test::kNoLimit), before, 1e-3);
  law.observe({t_ns += 16'000'000, 0.01, 0.002, 0.0});
  EXPECT_NEAR(law.step(t_ns, test::kNoLimit), before, 2e-3);
}

}  // namespace
}  // namespace ovws
