/// A loop of one mode in simulation: disturbance, control law, and corrections that are shown some
/// steps after their samples.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "core/control/disturbance.hpp"
#include "core/control/mode_law.hpp"

namespace ovws::test {

constexpr double kNoLimit = 1e9;                            // waves
constexpr double kFrame = 1.0 / 200.0, kStep = 1.0 / 60.0;  // seconds

/// Delays of a loop in steps, which follow each other in turn.
using Delays = std::vector<int>;

inline LoopTiming timing_of(const Delays& delays, double step_s) {
  double sum = 0.0;
  for (const int steps : delays) sum += steps;
  return {step_s, step_s * sum / double(delays.size())};
}

/// Residuals of a loop with one sample a step. `noise_waves`: RMS noise of the samples, which the
/// residuals do not contain.
inline std::vector<double> residuals_of(ModeLaw& law, std::span<const double> disturbance,
                                        double step_s, double noise_waves = 0.0,
                                        const Delays& delays = {1}) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  const std::int64_t step_ns = std::llround(1e9 * step_s);
  const std::int64_t delay_ns = std::llround(1e9 * timing_of(delays, step_s).delay_s);
  std::vector<double> residuals, corrections;
  std::int64_t t_ns = 1'000'000'000;
  for (std::size_t k = 0; k < disturbance.size(); ++k, t_ns += step_ns) {
    const auto delay = std::size_t(delays[k % delays.size()]);
    const double shown = k < delay ? 0.0 : corrections[k - delay];
    const double residual = disturbance[k] - shown;
    residuals.push_back(residual);
    law.observe({t_ns, residual + noise_waves * noise(random), noise_waves, shown});
    corrections.push_back(law.step(t_ns + delay_ns, kNoLimit));
  }
  return residuals;
}

inline double rms_of(std::span<const double> values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / double(values.size()));
}

/// What a loop leaves of a sine at its frequency, relative to the sine. `cycles`: whole cycles in
/// `steps`. The sine is weak, so that no law takes it for a jump.
inline std::complex<double> left_of_sine(ModeLaw& law, int cycles, int steps, double step_s,
                                         const Delays& delays) {
  constexpr int kSettle = 20;  // times `steps`, until the loop's beginning is forgotten
  constexpr double kAmplitude = 1e-3;
  std::vector<double> sine;
  const double angle = 2.0 * std::numbers::pi * cycles / steps;
  for (int k = 0; k < (kSettle + 1) * steps; ++k) sine.push_back(kAmplitude * std::sin(angle * k));
  const auto left = residuals_of(law, sine, step_s, 0.0, delays);
  std::complex<double> found = 0.0, there = 0.0;
  for (int k = kSettle * steps; k < int(sine.size()); ++k) {
    found += left[std::size_t(k)] * std::polar(1.0, -angle * k);
    there += sine[std::size_t(k)] * std::polar(1.0, -angle * k);
  }
  return found / there;
}

/// Checks that a loop leaves of sines what the transfer function of its law says, for corrections
/// that are shown one step after their samples, two, and one or two in turn. In turn, the mean of
/// both delays' phases also reduces the correction. `make` makes a law.
template <class MakeLaw>
void expect_leaves_what_transfer_says(MakeLaw make, double step_s, double tolerance) {
  constexpr int kSteps = 100;
  for (const Delays& delays : {Delays{1}, Delays{2}, Delays{1, 2}}) {
    for (const int cycles : {1, 5, 20, 45}) {
      const double hz = cycles / (kSteps * step_s);
      const double kept = delays.size() == 2 ? std::cos(std::numbers::pi * hz * step_s) : 1.0;
      auto law = make();
      const auto expected = 1.0 - kept * law.transfer(std::array{hz}, timing_of(delays, step_s))[0];
      const auto found = left_of_sine(law, cycles, kSteps, step_s, delays);
      EXPECT_LT(std::abs(found - expected), tolerance)
          << hz << " Hz, " << delays.size() << " delays from " << delays[0] << " steps on";
    }
  }
}

/// Samples of a disturbance without noise.
inline std::vector<double> samples_of(const Disturbance& disturbance, double step_s, int count,
                                      std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<double> all(std::size_t(count), 0.0);
  for (const Oscillator& part : disturbance.parts) {
    const Eigen::Matrix2d moved = part.transition(step_s);
    const Eigen::Matrix2d free = part.variances().asDiagonal();
    const Eigen::Matrix2d driven = free - moved * free * moved.transpose();
    const double a = std::sqrt(driven(0, 0)), b = driven(1, 0) / a;
    const double c = std::sqrt(std::max(0.0, driven(1, 1) - b * b));
    Eigen::Vector2d state(std::sqrt(free(0, 0)) * normal(random),
                          std::sqrt(free(1, 1)) * normal(random));
    for (double& waves : all) {
      waves += state[0];
      const double first = normal(random), second = normal(random);
      state = moved * state + Eigen::Vector2d(a * first, b * first + c * second);
    }
  }
  return all;
}

}  // namespace ovws::test
