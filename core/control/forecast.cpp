#include "core/control/forecast.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/control/integrator.hpp"

namespace ovws {
namespace {

constexpr int kFrequencies = 8000;  // for steps above 2.5 ms as fine as the narrowest line
constexpr double kLeastGain = 0.02, kMostGain = 1.0, kGainRatio = 1.06;

std::vector<double> frequencies(double step_s) {
  std::vector<double> all;
  const double step_hz = 0.5 / (step_s * kFrequencies);
  for (int k = 0; k < kFrequencies; ++k) all.push_back((k + 0.5) * step_hz);
  return all;
}

struct Densities {
  std::vector<double> hz;
  std::vector<double> disturbance;  ///< wave^2/Hz
  double noise = 0.0;               ///< wave^2/Hz
};

Densities densities(const Disturbance& disturbance, double step_s) {
  Densities found{frequencies(step_s), {}, 2.0 * step_s * std::pow(disturbance.noise_waves, 2)};
  for (const double hz : found.hz) {
    found.disturbance.push_back(disturbance.sampled_power_per_hz(hz, step_s));
  }
  return found;
}

LoopForecast forecast(const ModeLaw& law, const Densities& of, const LoopTiming& timing) {
  const auto passed = law.transfer(of.hz, timing);
  double power = 0.0, greatest = 0.0;
  for (std::size_t k = 0; k < passed.size(); ++k) {
    power += std::norm(1.0 - passed[k]) * of.disturbance[k] + std::norm(passed[k]) * of.noise;
    greatest = std::max(greatest, std::abs(passed[k]));
  }
  const double step_hz = 2.0 * of.hz.front();
  return {std::sqrt(power * step_hz), 1.0 / greatest};
}

}  // namespace

LoopForecast forecast(const ModeLaw& law, const Disturbance& disturbance,
                      const LoopTiming& timing) {
  return forecast(law, densities(disturbance, timing.step_s), timing);
}

double best_gain(const Disturbance& disturbance, const LoopTiming& timing, double leak,
                 double least_margin, double frames) {
  Densities of = densities(disturbance, timing.step_s);
  const double noise = of.noise;
  double best = kLeastGain, least = std::numeric_limits<double>::infinity();
  for (double gain = kLeastGain; gain <= kMostGain; gain *= kGainRatio) {
    of.noise = noise / Integrator::counted_frames(gain, frames);
    const LoopForecast found = forecast(Integrator(gain, leak, 0.0), of, timing);
    if (found.gain_margin < least_margin || !(found.residual_waves < least)) continue;
    least = found.residual_waves;
    best = gain;
  }
  return best;
}

}  // namespace ovws
