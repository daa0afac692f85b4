#include "core/control/integrator.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include "tests/unit/control/simulated_loop.hpp"

namespace ovws {
namespace {

constexpr double kStep = 1.0 / 60.0;

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
      for (const int cycles : {1, 5, 20, 45}) {
        const double hz = cycles / (100 * kStep);
        Integrator law(gain, leak, 0.0);
        const double expected = std::abs(1.0 - law.transfer(std::array{hz}, kStep)[0]);
        EXPECT_NEAR(test::left_of_sine(law, cycles, 100, kStep), expected, 1e-6) << hz;
      }
    }
  }
}

/// A frame of an older correction tells what that correction left: its error is not counted twice.
TEST(Integrator, CountsFromTheCorrectionOfTheFrame) {
  Integrator law(1.0, 0.0, 0.0);
  law.observe({.t_ns = 1, .residual_waves = 0.5, .shown_waves = 0.0});
  law.observe({.t_ns = 2, .residual_waves = 0.5, .shown_waves = 0.0});
  EXPECT_DOUBLE_EQ(law.correction_at(3), 0.5);
}

}  // namespace
}  // namespace ovws
