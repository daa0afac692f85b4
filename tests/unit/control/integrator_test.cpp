#include "core/control/integrator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace ovws {
namespace {

constexpr std::int64_t kStepNs = 50'000'000;

/// A bench whose hidden aberration the correction is subtracted from.
struct Plant {
  std::vector<int> modes_j;
  std::vector<double> hidden;
  double sign = 1.0;
  std::int64_t now_ns = 0;

  std::vector<float> residual(const Integrator& loop) const {
    std::vector<float> left;
    for (std::size_t k = 0; k < modes_j.size(); ++k) {
      double waves = hidden[k];
      for (const Mode& one : loop.correction()) waves -= one.j == modes_j[k] ? one.waves : 0.0;
      left.push_back(float(sign * waves));
    }
    return left;
  }
  LoopEnd step(Integrator& loop) {
    now_ns += kStepNs;
    return loop.step(modes_j, residual(loop), now_ns);
  }
};

TEST(Integrator, LeavesAPowerOfOneMinusGain) {
  Plant plant{{3, 4}, {0.5, -0.2}};
  Integrator loop({.gain = 0.5}, {}, 0);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(plant.step(loop), LoopEnd::none);
  const auto left = plant.residual(loop);
  EXPECT_NEAR(double(left[0]), 0.5 * std::pow(0.5, 10), 1e-6);
  EXPECT_NEAR(double(left[1]), -0.2 * std::pow(0.5, 10), 1e-6);
  EXPECT_EQ(loop.steps(), 10);
}

TEST(Integrator, WithLeakSettlesWhereLeakAndGainMeet) {
  Plant plant{{3}, {0.5}};
  Integrator loop({.gain = 0.3, .leak = 0.1}, {}, 0);
  for (int k = 0; k < 200; ++k) plant.step(loop);
  EXPECT_NEAR(loop.correction()[0].waves, 0.5 * 0.3 / 0.4, 1e-6);
}

TEST(Integrator, CorrectsOnlyTheModesAskedForAndNeverPiston) {
  Plant plant{{0, 3, 4}, {1.0, 0.5, 0.5}};
  Integrator loop({.gain = 1.0, .modes = {4}, .gains = {{4, 0.25}}}, {{3, 0.1}}, 0);
  plant.step(loop);
  EXPECT_EQ(loop.correction(), (std::vector<Mode>{{3, 0.1}, {4, 0.125}}));
  Integrator all({.gain = 1.0}, {}, 0);
  plant.step(all);
  EXPECT_EQ(all.correction(), (std::vector<Mode>{{3, 0.5}, {4, 0.5}}));
}

TEST(Integrator, DoesNotWindUpAndOpensAtItsLimit) {
  Plant plant{{3}, {3.0}};
  Integrator loop({.gain = 0.5, .limit_waves = 1.0, .patience_s = 1.0}, {}, 0);
  LoopEnd end = LoopEnd::none;
  int steps = 0;
  while (end == LoopEnd::none && steps < 1000) end = plant.step(loop), ++steps;
  EXPECT_EQ(end, LoopEnd::at_limit);
  EXPECT_NEAR(steps, 20, 3) << "a second of steps after the limit was reached";
  EXPECT_DOUBLE_EQ(loop.correction()[0].waves, 1.0);
  plant.hidden[0] = 0.5;  // leads back at once: nothing has wound up
  plant.step(loop);
  EXPECT_DOUBLE_EQ(loop.correction()[0].waves, 0.75);
}

TEST(Integrator, OpensWhenTheResidualGrows) {
  Plant plant{{3}, {0.1}, -1.0};  // a sign that is wrong
  Integrator loop({.gain = 0.2, .limit_waves = 1e6, .patience_s = 2.0}, {}, 0);
  LoopEnd end = LoopEnd::none;
  int steps = 0;
  while (end == LoopEnd::none && steps < 1000) end = plant.step(loop), ++steps;
  EXPECT_EQ(end, LoopEnd::growing);
  EXPECT_LT(steps, 100);
}

TEST(Integrator, DoesNotOpenForASuddenAberrationThatItCorrects) {
  Plant plant{{3}, {0.001}};
  Integrator loop({.gain = 0.3}, {}, 0);
  for (int k = 0; k < 100; ++k) plant.step(loop);
  plant.hidden[0] = 1.0;
  for (int k = 0; k < 100; ++k) EXPECT_EQ(plant.step(loop), LoopEnd::none);
  EXPECT_LT(std::abs(double(plant.residual(loop)[0])), 1e-3);
}

TEST(Integrator, WaitsForUsableFramesAsLongAsItsPatience) {
  Integrator loop({.patience_s = 2.0}, {}, 0);
  EXPECT_EQ(loop.wait(1'999'000'000), LoopEnd::none);
  EXPECT_EQ(loop.wait(2'000'000'000), LoopEnd::too_few_spots);
}

TEST(Integrator, WaitsLongerWhileLostSpotsAreBeingFound) {
  constexpr std::int64_t kS = 1'000'000'000;
  Integrator loop({.patience_s = 2.0}, {}, 0);
  EXPECT_EQ(loop.wait(3 * kS, 2 * kS), LoopEnd::none);
  EXPECT_EQ(loop.wait(4 * kS, 2 * kS), LoopEnd::too_few_spots);
  EXPECT_EQ(loop.wait(9 * kS, 8 * kS), LoopEnd::none);
  EXPECT_EQ(loop.wait(10 * kS, 9 * kS), LoopEnd::too_few_spots);  // found, and never usable
}

}  // namespace
}  // namespace ovws
