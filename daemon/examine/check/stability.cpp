#include "daemon/examine/check/measured.hpp"

#include <algorithm>
#include <cmath>

#include "core/control/spectrum.hpp"

namespace ovws::examine {
namespace {

constexpr int kFirstMode = 3;
constexpr double kLineShare = 0.3;  // of the variance, that a spectral line must hold

std::vector<const Frame*> valid_frames(const Record& record) {
  std::vector<const Frame*> frames;
  for (const Frame& frame : record.frames) {
    if (frame.valid) frames.push_back(&frame);
  }
  return frames;
}

/// Noise of white samples by third differences, whose variance is 20 times theirs.
double noise_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (std::size_t i = 3; i < values.size(); ++i) {
    const double d = values[i] - 3.0 * values[i - 1] + 3.0 * values[i - 2] - values[i - 3];
    sum += d * d;
  }
  return values.size() < 4 ? 0.0 : std::sqrt(sum / 20.0 / double(values.size() - 3));
}

/// Slope of the straight line through the values, per unit of `times`.
double slope_of(const std::vector<double>& times, const std::vector<double>& values) {
  const double t = study::mean_of(times).value, v = study::mean_of(values).value;
  double products = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    products += (times[i] - t) * (values[i] - v);
    squares += (times[i] - t) * (times[i] - t);
  }
  return squares > 0.0 ? products / squares : 0.0;
}

ModeStability mode_of(int j, const std::vector<double>& times, const std::vector<double>& values) {
  ModeStability mode;
  mode.j = j;
  const study::Mean mean = study::mean_of(values);
  mode.mean = mean.value;
  mode.noise = noise_of(values);
  mode.spread = mean.standard_error * std::sqrt(double(values.size()));
  mode.drift = slope_of(times, values) * (times.back() - times.front());
  return mode;
}

double stated_of(const std::vector<const Frame*>& frames, std::size_t mode) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const Frame* frame : frames) {
    if (frame->sigmas.empty()) continue;
    sum += frame->sigmas[mode] * frame->sigmas[mode];
    ++count;
  }
  return count > 0 ? std::sqrt(sum / double(count)) : study::kUnknown;
}

ModeSeries series_of(const std::vector<const Frame*>& frames) {
  ModeSeries series;
  series.modes_waves.resize(frames.front()->waves.size());
  for (const Frame* frame : frames) {
    if (!series.times_s.empty() && frame->t_s <= series.times_s.back()) continue;
    series.times_s.push_back(frame->t_s);
    for (std::size_t k = 0; k < frame->waves.size(); ++k) {
      series.modes_waves[k].push_back(frame->waves[k]);
    }
  }
  return series;
}

/// Frequency of a line that holds a good part of the variance above 1 Hz; 0: none does.
double line_of(const ModeSeries& series) {
  const Spectrum found =
      spectrum(series, segment_s(series.times_s.back() - series.times_s.front()));
  double all = 0.0;
  std::size_t most = 0;
  for (std::size_t k = 0; k < found.power_per_hz.size(); ++k) {
    all += found.power_per_hz[k];
    if (found.power_per_hz[k] > found.power_per_hz[most]) most = k;
  }
  if (all <= 0.0 || found.hz(most) < 1.0) return 0.0;
  double line = 0.0;  // a Hann window spreads a line over some bins
  const std::size_t from = most < 2 ? 0 : most - 2;
  for (std::size_t k = from; k < std::min(most + 3, found.power_per_hz.size()); ++k) {
    line += found.power_per_hz[k];
  }
  return line > kLineShare * all ? found.hz(most) : 0.0;
}

void add_mode(Stability& all, const ModeStability& mode, double& most) {
  const double trend = mode.drift * mode.drift / 12.0;
  const double noise = std::isnan(mode.stated) ? mode.noise : mode.stated;
  const double moves = std::max(0.0, mode.spread * mode.spread - noise * noise - trend);
  all.noise += mode.noise * mode.noise;
  all.stated += mode.stated * mode.stated;
  all.drift += mode.drift * mode.drift;
  all.motion += moves;
  if (mode.j >= kFirstMode) all.offset += mode.mean * mode.mean;
  if (moves > most) all.strongest_j = mode.j;
  most = std::max(most, moves);
}

}  // namespace

Stability stability_of(const Record& record) {
  Stability all;
  const auto frames = valid_frames(record);
  if (int(frames.size()) < kMinFrames) return all;
  const ModeSeries series = series_of(frames);
  all.stated = 0.0;
  double most = 0.0;
  for (std::size_t k = 0; k < series.modes_waves.size(); ++k) {
    all.modes.push_back(mode_of(record.modes_j[k], series.times_s, series.modes_waves[k]));
    all.modes.back().stated = stated_of(frames, k);
    add_mode(all, all.modes.back(), most);
  }
  for (double* sum : {&all.noise, &all.stated, &all.drift, &all.motion, &all.offset}) {
    *sum = std::sqrt(*sum);
  }
  all.frequency_hz = line_of(series);
  all.frame_rate_hz = 1.0 / median_interval_s(series.times_s);
  all.usable = true;
  return all;
}

Seconds seconds_of(const Record& record) {
  Seconds seconds;
  const auto frames = valid_frames(record);
  if (frames.empty()) return seconds;
  const std::size_t modes = frames.front()->waves.size();
  seconds.waves.resize(modes);
  std::size_t begin = 0;
  while (begin < frames.size()) {
    const double second = std::floor(frames[begin]->t_s - frames.front()->t_s);
    std::size_t end = begin;
    std::vector<double> sums(modes, 0.0);
    for (; end < frames.size() && frames[end]->t_s - frames.front()->t_s < second + 1.0; ++end) {
      for (std::size_t k = 0; k < modes; ++k) sums[k] += frames[end]->waves[k];
    }
    seconds.times_s.push_back(second + 0.5);
    for (std::size_t k = 0; k < modes; ++k) {
      seconds.waves[k].push_back(sums[k] / double(end - begin));
    }
    begin = end;
  }
  return seconds;
}

AllanCurve allan_of(const Record& record) {
  AllanCurve curve;
  const auto frames = valid_frames(record);
  if (int(frames.size()) < kMinFrames) return curve;
  const ModeSeries series = series_of(frames);
  const double step_s = median_interval_s(series.times_s);
  for (std::size_t length = 1; length * 4 <= series.times_s.size(); length *= 2) {
    double sum = 0.0;
    std::size_t count = 0;
    for (const auto& values : series.modes_waves) {
      std::vector<double> means;
      for (std::size_t i = 0; i + length <= values.size(); i += length) {
        double mean = 0.0;
        for (std::size_t k = 0; k < length; ++k) mean += values[i + k] / double(length);
        means.push_back(mean);
      }
      for (std::size_t i = 1; i < means.size(); ++i) sum += std::pow(means[i] - means[i - 1], 2);
      count = means.size() - 1;
    }
    curve.times_s.push_back(double(length) * step_s);
    curve.waves.push_back(std::sqrt(0.5 * sum / double(count)));
  }
  return curve;
}

double square_waves(const Frame& frame, const std::vector<int>& modes_j) {
  double sum = 0.0;
  for (std::size_t k = 0; k < frame.waves.size(); ++k) {
    if (modes_j[k] >= kFirstMode) sum += frame.waves[k] * frame.waves[k];
  }
  return sum;
}

double rms_waves(const Record& record) {
  double sum = 0.0;
  const auto frames = valid_frames(record);
  for (const Frame* frame : frames) sum += square_waves(*frame, record.modes_j);
  return frames.empty() ? study::kUnknown : std::sqrt(sum / double(frames.size()));
}

}  // namespace ovws::examine
