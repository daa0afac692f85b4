#include "core/control/integrator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/control/simulated_loop.hpp"

namespace ovws {
namespace {

using test::kStep;

TEST(Integrator, LeavesAPowerOfOneMinusGain) {
  Integrator law(0.3, 0.0, 0.0);
  const auto left = test::residuals_of(law, std::vector<double>(11, 0.5), kStep);
  for (std::size_t k = 0; k < left.size(); ++k) {
    EXPECT_NEAR(left[k], 0.5 * std::pow(0.7, double(k)), 1e-12);
  }
}

TEST(Integrator, WithLeakSettlesWhereLeakAndGainMeet) {
  Integrator law(0.3, 0.1, 0.0);
  const auto left = test::residuals_of(law, std::vector<double>(200, 0.5), kStep);
  EXPECT_NEAR(left.back(), 0.5 * 0.1 / 0.4, 1e-9);
}

TEST(Integrator, LeavesOfASineWhatItsTransferFunctionSays) {
  for (const double gain : {0.2, 0.5, 0.9}) {
    for (const double leak : {0.0, 0.05}) {
      test::expect_leaves_what_transfer_says([&] { return Integrator(gain, leak, 0.0); }, kStep,
                                             1e-6);
    }
  }
}

/// With a delay of two steps, an integrator of residuals is unstable from the gain 1 on.
TEST(Integrator, IsStableWithAnyDelay) {
  for (const test::Delays& delays : {test::Delays{2}, test::Delays{1, 2}, test::Delays{3}}) {
    Integrator law(1.0, 0.0, 0.0);
    const auto left = test::residuals_of(law, std::vector<double>(50, 0.5), kStep, 0.0, delays);
    EXPECT_NEAR(left.back(), 0.0, 1e-12);
  }
}

/// A frame of an older correction tells what that correction left: its error is not counted twice.
TEST(Integrator, CountsFromTheCorrectionOfTheFrame) {
  Integrator law(1.0, 0.0, 0.0);
  law.observe({.t_ns = 1, .residual_waves = 0.5, .shown_waves = 0.0});
  EXPECT_DOUBLE_EQ(law.step(2, test::kNoLimit), 0.5);
  law.observe({.t_ns = 3, .residual_waves = 0.5, .shown_waves = 0.0});
  EXPECT_DOUBLE_EQ(law.step(4, test::kNoLimit), 0.5);
}

/// The gain counts per step, whatever the number of frames, and the newest frame counts most.
TEST(Integrator, TakesAStepsFramesAsIfEachHadAStep) {
  Integrator law(0.75, 0.0, 0.2), newest(1.0, 0.0, 0.2);
  EXPECT_DOUBLE_EQ(law.step(1, test::kNoLimit), 0.2) << "no frame, no change";
  for (const double waves : {0.2, 0.6}) {
    law.observe({.t_ns = 2, .residual_waves = waves, .shown_waves = 0.2});
    newest.observe({.t_ns = 2, .residual_waves = waves, .shown_waves = 0.2});
  }
  // Two steps of gain 0.5: to 0.4 and 0.8.
  EXPECT_DOUBLE_EQ(law.step(3, test::kNoLimit), 0.5 * (0.5 * (0.2 + 0.4) + 0.8));
  EXPECT_DOUBLE_EQ(law.step(4, test::kNoLimit), 0.55);
  EXPECT_DOUBLE_EQ(newest.step(3, test::kNoLimit), 0.8);
}

TEST(Integrator, CountsAsManyFramesAsItsWeightsAmountTo) {
  EXPECT_DOUBLE_EQ(Integrator::counted_frames(1.0, 3.5), 1.0);
  EXPECT_DOUBLE_EQ(Integrator::counted_frames(0.0, 3.5), 3.5);
  EXPECT_NEAR(Integrator::counted_frames(0.01, 3.5), 3.5, 1e-3);
  EXPECT_DOUBLE_EQ(Integrator::counted_frames(0.5, 1.0), 1.0);
  // Weights 1 and 0.5.
  EXPECT_DOUBLE_EQ(Integrator::counted_frames(0.75, 2.0), 1.5 * 1.5 / 1.25);
}

TEST(Integrator, TakesTheNewestOfManyFrames) {
  Integrator law(0.5, 0.0, 0.0);
  for (int k = 0; k < 100; ++k) law.observe({.residual_waves = k < 84 ? 7.0 : 0.4});
  EXPECT_NEAR(law.step(1, test::kNoLimit), 0.2, 1e-12);
}

}  // namespace
}  // namespace ovws
