#include "core/control/oscillator.hpp"

#include <cmath>

#include "core/base/angle.hpp"

namespace ovws {
namespace {

constexpr int kAliases = 4;  // beyond its own; the power falls with the fourth power of frequency

}  // namespace

double Oscillator::power_per_hz(double at_hz) const {
  const double own = hz * hz, there = at_hz * at_hz;
  const double beside = there - own;
  const double lost = 4.0 * damping * damping * own * there;
  return rms_waves * rms_waves * 8.0 * damping * hz * own / (kTwoPi * (beside * beside + lost));
}

double Oscillator::sampled_power_per_hz(double at_hz, double step_s) const {
  double sum = power_per_hz(at_hz);
  const int aliases = kAliases + int(std::ceil(hz * step_s));
  for (int k = 1; k <= aliases; ++k) {
    sum += power_per_hz(k / step_s - at_hz) + power_per_hz(k / step_s + at_hz);
  }
  return sum;
}

Eigen::Matrix2d Oscillator::transition(double seconds) const {
  const double w = kTwoPi * hz;
  const double decay = damping * w;
  const double turn = w * std::sqrt(1.0 - damping * damping);
  const double angle = turn * seconds;
  const double across = angle > 1e-6 ? std::sin(angle) / turn : seconds;  // damping 1: no turn
  Eigen::Matrix2d moved;
  moved << std::cos(angle) + decay * across, across, -w * w * across,
      std::cos(angle) - decay * across;
  return std::exp(-decay * seconds) * moved;
}

Eigen::Vector2d Oscillator::variances() const {
  const double w = kTwoPi * hz;
  return rms_waves * rms_waves * Eigen::Vector2d(1.0, w * w);
}

}  // namespace ovws
