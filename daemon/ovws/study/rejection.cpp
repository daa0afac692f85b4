#include "daemon/ovws/study/rejection.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace ovws::study {
namespace {

constexpr double kMaxSegment_s = 60.0;
constexpr int kMinCount = 8;  // intervals per segment
/// First usable bin: under a Hann window, removing the mean also affects the bin before it.
constexpr std::size_t kFirstBin = 1;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

double db_of(double power_ratio) {
  return 10.0 * std::log10(power_ratio);
}

std::vector<double> hann(int count) {
  std::vector<double> window;
  for (int k = 0; k < count; ++k) window.push_back(0.5 - 0.5 * std::cos(kTwoPi * k / count));
  return window;
}

/// Adds the power spectra of the windowed, mean-free segments of a series to `sums`. Segments
/// overlap by half. Returns their number.
int add_segments(const std::vector<double>& series, const std::vector<double>& window,
                 std::vector<double>& sums) {
  Eigen::FFT<double> fft;
  const std::size_t count = window.size();
  std::vector<double> segment(count);
  std::vector<std::complex<double>> transform;
  int segments = 0;
  for (std::size_t first = 0; first + count <= series.size(); first += count / 2, ++segments) {
    double mean = 0.0;
    for (std::size_t k = 0; k < count; ++k) mean += series[first + k] / double(count);
    for (std::size_t k = 0; k < count; ++k) segment[k] = window[k] * (series[first + k] - mean);
    fft.fwd(transform, segment);
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += std::norm(transform[k + 1]);
  }
  return segments;
}

/// Whether from_hz <= hz < to_hz, with a tolerance for rounding of the edges.
bool is_between(double hz, double from_hz, double to_hz) {
  constexpr double kTolerance = 1.0 - 1e-9;
  return hz >= from_hz * kTolerance && hz < to_hz * kTolerance;
}

double sum_between(const Spectrum& spectrum, double from_hz, double to_hz) {
  double sum = 0.0;
  for (std::size_t k = 0; k < spectrum.power_per_hz.size(); ++k) {
    if (is_between(spectrum.hz(k), from_hz, to_hz)) sum += spectrum.power_per_hz[k];
  }
  return sum;
}

/// Predicted rejection of the integrator in a band, weighted with the open loop's power, dB.
double integrator_band_db(const Spectrum& open, double from_hz, double to_hz, const LoopLaw& law) {
  double there = 0.0, left = 0.0;
  for (std::size_t k = 0; k < open.power_per_hz.size(); ++k) {
    if (!is_between(open.hz(k), from_hz, to_hz)) continue;
    there += open.power_per_hz[k];
    left += open.power_per_hz[k] * std::pow(10.0, 0.1 * integrator_db(open.hz(k), law));
  }
  return db_of(left / there);
}

}  // namespace

double median_interval_s(const std::vector<double>& times_s) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < times_s.size(); ++k) intervals.push_back(times_s[k] - times_s[k - 1]);
  const auto middle = intervals.begin() + std::ptrdiff_t(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

double rms_waves(const Recording& recording) {
  double squares = 0.0;
  for (const auto& mode : recording.modes_waves) {
    for (const double waves : mode) squares += waves * waves;
  }
  return std::sqrt(squares / double(recording.times_s.size()));
}

std::vector<double> resample(const std::vector<double>& times_s, const std::vector<double>& values,
                             double begin_s, double step_s, int count) {
  std::vector<double> out;
  std::size_t next = 0;  // the first sample at or after t
  for (int k = 0; k < count; ++k) {
    const double t = begin_s + k * step_s;
    while (next < times_s.size() && times_s[next] < t) ++next;
    if (next == 0 || next == times_s.size()) {
      out.push_back(next == 0 ? values.front() : values.back());
      continue;
    }
    const double part = (t - times_s[next - 1]) / (times_s[next] - times_s[next - 1]);
    out.push_back(values[next - 1] + part * (values[next] - values[next - 1]));
  }
  return out;
}

double segment_s(double seconds) {
  return std::min(seconds / 2.1, kMaxSegment_s);
}

Spectrum spectrum(const Recording& recording, double segment_s) {
  const auto& times = recording.times_s;
  if (times.size() < 2) return {};
  const int count = int(std::lround(segment_s / median_interval_s(times)));
  if (count < kMinCount) return {};
  const double step_s = segment_s / count;
  const int samples = int((times.back() - times.front()) / step_s + 1e-6) + 1;
  const std::vector<double> window = hann(count);
  double squares = 0.0;
  for (const double w : window) squares += w * w;
  Spectrum found{1.0 / segment_s, std::vector<double>(std::size_t((count - 1) / 2), 0.0)};
  int segments = 0;
  for (const auto& mode : recording.modes_waves) {
    segments = add_segments(resample(times, mode, times.front(), step_s, samples), window,
                            found.power_per_hz);
  }
  if (segments == 0) return {};
  for (double& power : found.power_per_hz) power *= 2.0 * step_s / (squares * segments);
  return found;
}

std::vector<RejectionPoint> rejection(const Spectrum& open, const Spectrum& closed) {
  const double half = std::exp2(1.0 / 6.0);
  const std::size_t count = std::min(open.power_per_hz.size(), closed.power_per_hz.size());
  std::vector<RejectionPoint> points;
  for (std::size_t k = kFirstBin; k < count; ++k) {
    const double hz = open.hz(k), beyond = open.hz(count);
    const double from = std::max(hz / half, open.hz(kFirstBin));
    const double to = std::min(hz * half, beyond);
    points.push_back({hz, db_of(sum_between(closed, from, to) / sum_between(open, from, to))});
  }
  return points;
}

std::optional<double> crossing_hz(const std::vector<RejectionPoint>& rejection, double level_db) {
  if (rejection.empty() || rejection.front().db > level_db) return std::nullopt;
  for (std::size_t k = 1; k < rejection.size(); ++k) {
    const RejectionPoint &a = rejection[k - 1], &b = rejection[k];
    if (!(b.db > level_db)) continue;
    return a.hz * std::pow(b.hz / a.hz, (level_db - a.db) / (b.db - a.db));
  }
  return std::nullopt;
}

double integrator_db(double hz, const LoopLaw& law) {
  if (!(hz <= 0.5 * law.steps_hz)) return std::numeric_limits<double>::quiet_NaN();
  const auto delay = std::polar(1.0, -kTwoPi * hz / law.steps_hz);
  const double keeps = 1.0 - law.leak;
  return db_of(std::norm(1.0 - keeps * delay) / std::norm(1.0 - (keeps - law.gain) * delay));
}

std::vector<RejectionBand> octave_bands(const Spectrum& open, const Spectrum& closed,
                                        const LoopLaw& law) {
  const std::size_t count = std::min(open.power_per_hz.size(), closed.power_per_hz.size());
  if (count <= kFirstBin) return {};
  const double first = open.hz(kFirstBin), last = open.hz(count - 1);
  std::vector<RejectionBand> bands;
  double from = 0.1 * std::exp2(std::ceil(std::log2(first / 0.1) - 1e-9));
  for (; 2.0 * from <= last; from *= 2.0) {
    const double to = 2.0 * from;
    bands.push_back({from, to, db_of(sum_between(closed, from, to) / sum_between(open, from, to)),
                     integrator_band_db(open, from, to, law)});
  }
  return bands;
}

}  // namespace ovws::study
