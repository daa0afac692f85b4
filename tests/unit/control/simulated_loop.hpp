/// A loop of one mode in simulation: disturbance, control law, and a correction that is shown one
/// step after its sample.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "core/control/disturbance.hpp"
#include "core/control/mode_law.hpp"

namespace ovws::test {

/// Residuals of a loop with one sample a step. `noise_waves`: RMS noise of the samples, which the
/// residuals do not contain.
inline std::vector<double> residuals_of(ModeLaw& law, std::span<const double> disturbance,
                                        double step_s, double noise_waves = 0.0) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<double> residuals;
  double shown = 0.0;
  std::int64_t t_ns = 1'000'000'000;
  for (const double waves : disturbance) {
    residuals.push_back(waves - shown);
    law.observe({t_ns, waves - shown + noise_waves * noise(random), noise_waves, shown});
    t_ns += std::llround(1e9 * step_s);
    shown = law.correction_at(t_ns);
  }
  return residuals;
}

inline double rms_of(std::span<const double> values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / double(values.size()));
}

/// Amplitude of what a loop leaves of a sine, relative to the sine's. `cycles`: whole cycles in
/// `steps`. The sine is weak, so that no law takes it for a jump.
inline double left_of_sine(ModeLaw& law, int cycles, int steps, double step_s) {
  constexpr int kSettle = 20;  // times `steps`, until the loop's beginning is forgotten
  constexpr double kAmplitude = 1e-3;
  std::vector<double> sine;
  for (int k = 0; k < (kSettle + 1) * steps; ++k) {
    sine.push_back(kAmplitude * std::sin(2.0 * std::numbers::pi * cycles * k / steps));
  }
  const auto left = residuals_of(law, sine, step_s);
  return std::sqrt(2.0) / kAmplitude * rms_of(std::span(left).last(std::size_t(steps)));
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
