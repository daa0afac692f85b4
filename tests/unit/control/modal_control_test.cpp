#include "core/control/modal_control.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/control/integrator.hpp"
#include "core/control/loop_watch.hpp"
#include "core/control/predictor.hpp"

namespace ovws {
namespace {

constexpr std::int64_t kStepNs = 50'000'000;

ModalControl::MakeLaw integrators(double gain) {
  return [gain](int j, double correction_waves) {
    return std::make_unique<Integrator>(j == 4 ? 0.5 * gain : gain, 0.0, correction_waves);
  };
}

/// A loop with a watch, on a bench whose hidden aberration the correction is subtracted from.
struct Loop {
  Loop(const LoopSettings& settings, std::vector<Mode> correction)
      : control(settings, std::move(correction), integrators(settings.gain)), watch(settings, 0) {}

  ModalControl control;
  LoopWatch watch;
  std::vector<int> modes_j{3, 4};
  std::vector<double> hidden{0.5, -0.2};
  double sign = 1.0;
  std::int64_t now_ns = 0;

  std::vector<float> residual() const {
    std::vector<float> left;
    for (std::size_t k = 0; k < modes_j.size(); ++k) {
      double waves = hidden[k];
      for (const Mode& one : control.correction()) waves -= one.j == modes_j[k] ? one.waves : 0.0;
      left.push_back(float(sign * waves));
    }
    return left;
  }
  LoopEnd step() {
    now_ns += kStepNs;
    const std::vector<float> left = residual();
    const std::vector<float> unknown(left.size(), std::numeric_limits<float>::quiet_NaN());
    control.observe({now_ns, modes_j, left, unknown}, control.correction());
    control.step(now_ns);
    return watch.step(control.residual_rms_waves(), control.at_limit(), now_ns);
  }
};

TEST(ModalControl, HasALawForEachMode) {
  Loop loop({.gain = 0.5}, {});
  for (int k = 0; k < 10; ++k) EXPECT_EQ(loop.step(), LoopEnd::none);
  EXPECT_NEAR(double(loop.residual()[0]), 0.5 * std::pow(0.5, 10), 1e-6);
  EXPECT_NEAR(double(loop.residual()[1]), -0.2 * std::pow(0.75, 10), 1e-6);
  EXPECT_EQ(loop.control.steps(), 10);
}

TEST(ModalControl, CorrectsOnlyTheModesAskedForAndNeverPiston) {
  Loop loop({.gain = 0.5, .modes = {4}}, {{3, 0.1}});
  loop.modes_j = {0, 3, 4};
  loop.hidden = {1.0, 0.5, 0.5};
  loop.step();
  EXPECT_EQ(loop.control.correction(), (std::vector<Mode>{{3, 0.1}, {4, 0.125}}));
  EXPECT_NEAR(loop.control.residual_rms_waves(), 0.5, 1e-6);
  Loop all({.gain = 1.0}, {});
  all.modes_j = {0, 3, 4};
  all.hidden = {1.0, 0.5, 0.5};
  all.step();
  EXPECT_EQ(all.control.correction(), (std::vector<Mode>{{3, 0.5}, {4, 0.25}}));
}

TEST(ModalControl, BeginsEachLawWithTheCorrectionThatIsShown) {
  std::vector<std::pair<int, double>> begun;
  ModalControl control({}, {{3, 0.1}}, [&](int j, double waves) {
    begun.emplace_back(j, waves);
    return std::make_unique<Integrator>(0.5, 0.0, waves);
  });
  const std::vector<int> modes_j{3, 5};
  const std::vector<float> zeros(2, 0.0F);
  control.observe({1, modes_j, zeros, zeros}, control.correction());
  EXPECT_EQ(begun, (std::vector<std::pair<int, double>>{{3, 0.1}, {5, 0.0}}));
  control.step(2);
  EXPECT_EQ(control.correction(), (std::vector<Mode>{{3, 0.1}, {5, 0.0}}));
}

TEST(ModalControl, HoldsAnOffset) {
  Loop loop({.gain = 0.5, .offsets = {{4, 0.1}}}, {});
  for (int k = 0; k < 100; ++k) EXPECT_EQ(loop.step(), LoopEnd::none);
  EXPECT_NEAR(double(loop.residual()[0]), 0.0, 1e-6);
  EXPECT_NEAR(double(loop.residual()[1]), 0.1, 1e-6);
  EXPECT_NEAR(loop.control.residual_rms_waves(), 0.0, 1e-6);
}

/// A predictor would move the correction of a mode that frames do not have, though nothing is known
/// of it.
TEST(ModalControl, KeepsTheCorrectionOfModesThatFramesLack) {
  const Disturbance air{{{0.5, 1.0, 0.1}}, 0.01};
  ModalControl control({}, {},
                       [&](int, double waves) { return std::make_unique<Predictor>(air, waves); });
  const std::vector<int> both{3, 4}, one{3};
  const std::vector<float> waves{0.2F, 0.2F}, sigma{0.01F, 0.01F};
  control.observe({kStepNs, both, waves, sigma}, {});
  control.step(kStepNs);
  const double before = control.correction()[1].waves;
  EXPECT_GT(before, 0.1);
  for (std::int64_t k = 2; k < 1000; ++k) {
    control.observe({k * kStepNs, one, std::span(waves).first(1), std::span(sigma).first(1)}, {});
    control.step(k * kStepNs);
  }
  EXPECT_EQ(control.correction()[1].waves, before);
}

/// Frames of spot positions lack modes that templates measure.
TEST(ModalControl, IsAtTheLimitOnlyByModesOfTheLastFrame) {
  Loop loop({.gain = 1.0, .limit_waves = 0.3}, {});
  loop.hidden = {0.25, 5.0};
  loop.step();
  EXPECT_TRUE(loop.control.at_limit());
  EXPECT_EQ(loop.control.correction(), (std::vector<Mode>{{3, 0.25}, {4, 0.3}}));
  loop.modes_j = {3};
  loop.step();
  EXPECT_FALSE(loop.control.at_limit());
  EXPECT_EQ(loop.control.correction(), (std::vector<Mode>{{3, 0.25}, {4, 0.3}}));
}

TEST(ModalControl, LeavesOutModesThatAreNotFinite) {
  Loop loop({.gain = 1.0}, {});
  loop.hidden = {0.25, std::numeric_limits<double>::quiet_NaN()};
  loop.step();
  EXPECT_EQ(loop.control.correction(), (std::vector<Mode>{{3, 0.25}}));
  EXPECT_FALSE(loop.control.at_limit());
  EXPECT_NEAR(loop.control.residual_rms_waves(), 0.25, 1e-6);
}

TEST(LoopWatch, OpensAtTheLimitAndNothingHasWoundUp) {
  Loop loop({.gain = 0.5, .limit_waves = 1.0, .patience_s = 1.0}, {});
  loop.hidden = {3.0, 0.0};
  LoopEnd end = LoopEnd::none;
  int steps = 0;
  while (end == LoopEnd::none && steps < 1000) end = loop.step(), ++steps;
  EXPECT_EQ(end, LoopEnd::at_limit);
  EXPECT_NEAR(steps, 20, 3) << "a second of steps after the limit was reached";
  EXPECT_DOUBLE_EQ(loop.control.correction()[0].waves, 1.0);
  loop.hidden[0] = 0.5;  // leads back at once
  loop.step();
  EXPECT_DOUBLE_EQ(loop.control.correction()[0].waves, 0.75);
}

TEST(LoopWatch, OpensWhenTheResidualGrows) {
  Loop loop({.gain = 0.2, .limit_waves = 1e6, .patience_s = 2.0}, {});
  loop.hidden = {0.1, 0.0};
  loop.sign = -1.0;
  LoopEnd end = LoopEnd::none;
  int steps = 0;
  while (end == LoopEnd::none && steps < 1000) end = loop.step(), ++steps;
  EXPECT_EQ(end, LoopEnd::growing);
  EXPECT_LT(steps, 100);
}

TEST(LoopWatch, StaysClosedAtASuddenAberrationThatIsCorrected) {
  Loop loop({.gain = 0.3}, {});
  loop.hidden = {0.001, 0.0};
  for (int k = 0; k < 100; ++k) loop.step();
  loop.hidden[0] = 1.0;
  for (int k = 0; k < 100; ++k) EXPECT_EQ(loop.step(), LoopEnd::none);
  EXPECT_LT(std::abs(double(loop.residual()[0])), 1e-3);
}

TEST(LoopWatch, WaitsForUsableFramesAsLongAsItsPatience) {
  const LoopWatch watch({.patience_s = 2.0}, 0);
  EXPECT_EQ(watch.wait(1'999'000'000), LoopEnd::none);
  EXPECT_EQ(watch.wait(2'000'000'000), LoopEnd::too_few_spots);
}

TEST(LoopWatch, WaitsLongerWhileLostSpotsAreBeingFound) {
  constexpr std::int64_t kS = 1'000'000'000;
  const LoopWatch watch({.patience_s = 2.0}, 0);
  EXPECT_EQ(watch.wait(3 * kS, 2 * kS), LoopEnd::none);
  EXPECT_EQ(watch.wait(4 * kS, 2 * kS), LoopEnd::too_few_spots);
  EXPECT_EQ(watch.wait(9 * kS, 8 * kS), LoopEnd::none);
  EXPECT_EQ(watch.wait(10 * kS, 9 * kS), LoopEnd::too_few_spots);  // found, and never usable
}

}  // namespace
}  // namespace ovws
