#include "core/control/loop_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/control/integrator.hpp"
#include "core/control/predictor.hpp"

namespace ovws {
namespace {

constexpr std::size_t kLeastSamples = 64;
constexpr double kSegments = 4.0;  // of a series, at least; with those between them seven
constexpr double kMaxSegmentS = 20.0;
constexpr double kLeastNoiseShare = 0.01;  // of the disturbance: with less, margins are small
constexpr double kCautious = 1.5;          // factor by which more noise is assumed
constexpr int kMostCautious = 12;          // times

/// Mean interval of samples that follow each other; longer gaps do not count.
double regular_interval_s(const std::vector<double>& times_s) {
  const double limit = 1.5 * median_interval_s(times_s);
  double sum = 0.0, count = 0.0;
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    const double interval = times_s[k] - times_s[k - 1];
    if (interval < limit) sum += interval, count += 1.0;
  }
  return sum / count;
}

LoopForecast forecast_of_integrator(Disturbance disturbance, const LoopTiming& timing,
                                    double frames, double gain, double leak) {
  disturbance.noise_waves /= std::sqrt(Integrator::counted_frames(gain, frames));
  return forecast(Integrator(gain, leak, 0.0), disturbance, timing);
}

/// Forecasts for one mode. A step of the loop has `frames` frames.
void forecast_all(ModeModel& mode, const LoopTiming& timing, double frames, double gain,
                  double leak) {
  const Disturbance of_frames = mode.disturbance;
  mode.best_gain = best_gain(of_frames, timing, leak, LoopModel::kLeastMargin, frames);
  mode.integrator = forecast_of_integrator(of_frames, timing, frames, gain, leak);
  mode.optimised = forecast_of_integrator(of_frames, timing, frames, mode.best_gain, leak);
  Disturbance real = of_frames;
  real.noise_waves /= std::sqrt(frames);
  // More noise makes the predictor more cautious, until it has the least margin.
  Disturbance assumed = real;
  assumed.noise_waves = std::max(real.noise_waves, kLeastNoiseShare * real.rms_waves());
  for (int k = 0; k <= kMostCautious; ++k, assumed.noise_waves *= kCautious) {
    mode.predictor = forecast(Predictor(assumed, 0.0), real, timing);
    mode.disturbance.noise_waves = assumed.noise_waves * std::sqrt(frames);
    if (mode.predictor.gain_margin >= LoopModel::kLeastMargin) break;
  }
}

}  // namespace

const ModeModel* LoopModel::find(int j) const {
  const auto found = std::ranges::find(modes, j, &ModeModel::j);
  return found == modes.end() ? nullptr : &*found;
}

LoopModel identify(const DisturbanceSeries& series, const LoopTiming& timing, double gain,
                   double leak, const std::function<bool(double)>& go_on) {
  LoopModel model;
  model.timing = timing;
  const std::vector<double>& times = series.waves.times_s;
  if (times.size() < kLeastSamples) return model;
  model.seconds = times.back() - times.front();
  const double sample_s = regular_interval_s(times);
  // Whole intervals, so that resampling moves the samples as little as possible: interpolation
  // between samples would remove noise.
  const double segment =
      sample_s * std::floor(std::min(0.999 * model.seconds / kSegments, kMaxSegmentS) / sample_s);
  const double averaging = std::sqrt(series.frames_per_sample);
  const double frames_a_step = series.frames_per_sample * std::max(1.0, timing.step_s / sample_s);
  for (std::size_t k = 0; k < series.modes_j.size(); ++k) {
    if (go_on && !go_on(double(k) / double(series.modes_j.size()))) return {};
    const Spectrum found = spectrum({times, {series.waves.modes_waves[k]}}, segment);
    if (found.power_per_hz.empty()) return {};
    ModeModel mode;
    mode.j = series.modes_j[k];
    mode.disturbance = identify(found, sample_s, series.sigma_waves[k] / averaging);
    mode.disturbance.noise_waves *= averaging;
    forecast_all(mode, timing, frames_a_step, gain, leak);
    model.modes.push_back(std::move(mode));
  }
  return model;
}

}  // namespace ovws
