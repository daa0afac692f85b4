#include "core/control/loop_model.hpp"

#include <gtest/gtest.h>

#include "core/control/loop_laws.hpp"
#include "core/control/step_times.hpp"
#include "tests/support/time.hpp"
#include "tests/unit/control/simulated_loop.hpp"

namespace ovws {
namespace {

using test::kFrame;
using test::kStep;

constexpr LoopTiming kTiming{kStep, kStep};

DisturbanceSeries series_of(const std::vector<Disturbance>& modes, int frames) {
  DisturbanceSeries series;
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (int k = 0; k < frames; ++k) series.waves.times_s.push_back(1e4 + kFrame * k);
  for (const Disturbance& of : modes) {
    series.modes_j.push_back(3 + int(series.modes_j.size()));
    series.sigma_waves.push_back(of.noise_waves);
    auto& waves = series.waves.modes_waves.emplace_back(test::samples_of(of, kFrame, frames));
    for (double& one : waves) one += of.noise_waves * normal(random);
  }
  return series;
}

TEST(LoopModel, TellsWhatEachLawWillLeave) {
  const Disturbance air{{{0.5, 1.0, 0.05}}, 0.002}, line{{{5.0, 0.01, 0.05}}, 0.002};
  const LoopModel model = identify(series_of({air, line}, 12'000), kTiming, 0.3, 0.0);
  ASSERT_EQ(model.modes.size(), 2U);
  EXPECT_EQ(model.find(4), &model.modes[1]);
  EXPECT_EQ(model.find(5), nullptr);
  EXPECT_NEAR(model.seconds, 60.0, 0.1);
  for (const ModeModel& mode : model.modes) {
    EXPECT_LT(mode.optimised.residual_waves, mode.integrator.residual_waves);
    EXPECT_LT(mode.predictor.residual_waves, 0.8 * mode.optimised.residual_waves);
    EXPECT_GE(mode.predictor.gain_margin, LoopModel::kLeastMargin);
    EXPECT_GE(mode.optimised.gain_margin, LoopModel::kLeastMargin);
  }
  EXPECT_GT(model.modes[0].best_gain, 0.5);
}

TEST(LoopModel, OfTooFewSamplesHasNoModes) {
  const Disturbance air{{{0.5, 1.0, 0.05}}, 0.002};
  EXPECT_TRUE(identify(series_of({air}, 15), kTiming, 0.5, 0.0).modes.empty());
  EXPECT_TRUE(identify(series_of({air}, 63), kTiming, 0.5, 0.0).modes.empty());
  EXPECT_EQ(identify(series_of({air}, 200), kTiming, 0.5, 0.0).modes.size(), 1U);
}

/// Real frames come with jitter, at intervals that do not divide a segment.
TEST(LoopModel, FindsTheNoiseOfFramesWithJitter) {
  DisturbanceSeries series = series_of({{{{0.5, 1.0, 0.05}}, 0.002}}, 12'000);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> jitter(-1e-4, 1e-4);
  for (std::size_t k = 0; k < series.waves.times_s.size(); ++k) {
    series.waves.times_s[k] = 5.0013e-3 * double(k) + jitter(random);
  }
  series.sigma_waves = {0.0};
  const LoopModel model = identify(series, kTiming, 0.5, 0.0);
  EXPECT_NEAR(model.modes.at(0).disturbance.noise_waves, 0.002, 0.0003);
}

/// Samples that are means of four frames: the noise is that of one frame, and four a sample count
/// in the forecast.
TEST(LoopModel, CountsAllFramesOfAStep) {
  const Disturbance air{{{0.5, 1.0, 0.02}}, 0.01};
  DisturbanceSeries means = series_of({air}, 12'000);
  means.sigma_waves = {2.0 * air.noise_waves};
  means.frames_per_sample = 4.0;
  const LoopModel four = identify(means, {kFrame, kFrame}, 0.5, 0.0);
  const LoopModel one = identify(series_of({air}, 12'000), {kFrame, kFrame}, 0.5, 0.0);
  EXPECT_NEAR(four.modes.at(0).disturbance.noise_waves, 0.02, 0.003);
  EXPECT_NEAR(four.modes.at(0).integrator.residual_waves, one.modes.at(0).integrator.residual_waves,
              0.02 * one.modes.at(0).integrator.residual_waves);
}

TEST(StepLog, SummarisesTheLastSteps) {
  StepLog log;
  EXPECT_EQ(log.summary().steps, 0);
  for (int k = 1; k <= 100; ++k) {
    log.add({.times = {.settle_ms = 5.0, .refresh_ms = double(k)},
             .delay_ms = 2.0 * k,
             .has_newest = k <= 25});
  }
  const StepSummary some = log.summary();
  EXPECT_EQ(some.steps, 100);
  EXPECT_DOUBLE_EQ(some.p50_ms, 56.0);
  EXPECT_DOUBLE_EQ(some.p99_ms, 105.0);
  EXPECT_NEAR(some.mean.settle_ms, 5.0, 1e-12);
  EXPECT_NEAR(some.mean.refresh_ms, 50.5, 1e-12);
  EXPECT_NEAR(some.newest_share, 0.25, 1e-12);
  EXPECT_NEAR(some.timing().step_s, 0.0555, 1e-12);
  EXPECT_NEAR(some.timing().delay_s, 0.101, 1e-12);
  for (std::size_t k = 0; k < StepLog::kSteps; ++k) log.add({.times = {.wait_ms = 1.0}});
  EXPECT_EQ(log.summary().steps, int(StepLog::kSteps));
  EXPECT_DOUBLE_EQ(log.summary().p99_ms, 1.0);
}

/// A longer delay costs every law, and a predictor keeps its margin by caution.
TEST(LoopModel, AllowsForTheDelay) {
  const auto series = series_of({{{{0.5, 1.0, 0.05}, {5.0, 0.01, 0.02}}, 0.002}}, 12'000);
  const ModeModel soon = identify(series, kTiming, 0.5, 0.0).modes.at(0);
  const ModeModel late = identify(series, {kStep, 2.0 * kStep}, 0.5, 0.0).modes.at(0);
  EXPECT_GT(late.integrator.residual_waves, 1.2 * soon.integrator.residual_waves);
  EXPECT_GT(late.optimised.residual_waves, 1.2 * soon.optimised.residual_waves);
  EXPECT_GT(late.predictor.residual_waves, 1.2 * soon.predictor.residual_waves);
  EXPECT_LT(late.predictor.residual_waves, late.optimised.residual_waves);
  EXPECT_GE(late.predictor.gain_margin, LoopModel::kLeastMargin);
}

TEST(CheckModel, RefusesALawWithTooSmallAMargin) {
  LoopModel model;
  model.modes.resize(1);
  model.modes[0].j = 4;
  model.modes[0].optimised.gain_margin = 1.0;
  model.modes[0].predictor.gain_margin = 0.4;
  const auto check = [&](const LoopSettings& settings) {
    return bool(check_model(settings, &model, {4}));
  };
  EXPECT_FALSE(check({.law = LawName::predictor}));
  EXPECT_TRUE(check({.law = LawName::predictor, .gains = {{4, 0.3}}}));
  EXPECT_TRUE(check({.law = LawName::optimised}));
  EXPECT_TRUE(check({.law = LawName::integrator}));
}

TEST(RecentTime, IsThatOfTheStatedShareOfTheSteps) {
  using test::kMs;
  RecentTime time;
  EXPECT_EQ(time.ns(0.5), 0);
  time.add(300'000 * kMs);
  for (int k = 0; k < 3; ++k) time.add(16 * kMs);
  EXPECT_EQ(time.ns(0.5), 16 * kMs);
  for (int k = 0; k < 100; ++k) time.add(17 * kMs);
  time.add(300'000 * kMs);
  EXPECT_EQ(time.ns(0.5), 17 * kMs);
  EXPECT_EQ(time.ns(0.95), 17 * kMs);
  for (int k = 0; k < 2; ++k) time.add(20 * kMs);
  EXPECT_EQ(time.ns(0.95), 20 * kMs);
}

}  // namespace
}  // namespace ovws
