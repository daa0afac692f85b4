#include "core/control/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/median.hpp"

namespace ovws {
namespace {

constexpr double kMaxSegment_s = 60.0;
constexpr int kMinCount = 8;  // intervals per segment

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

}  // namespace

double median_interval_s(const std::vector<double>& times_s) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < times_s.size(); ++k) intervals.push_back(times_s[k] - times_s[k - 1]);
  return median(std::move(intervals));
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
    const double before_s = t - times_s[next - 1], after_s = times_s[next] - t;
    const double part = std::min(before_s, after_s) > 0.5 * step_s ? before_s / (before_s + after_s)
                                                                   : double(before_s > after_s);
    out.push_back(values[next - 1] + part * (values[next] - values[next - 1]));
  }
  return out;
}

double segment_s(double seconds) {
  return std::min(seconds / 2.1, kMaxSegment_s);
}

Spectrum spectrum(const ModeSeries& series, double length_s) {
  const auto& times = series.times_s;
  if (times.size() < 2) return {};
  const int count = int(std::lround(length_s / median_interval_s(times)));
  if (count < kMinCount) return {};
  const double step_s = length_s / count;
  const int samples = int((times.back() - times.front()) / step_s + 1e-6) + 1;
  const std::vector<double> window = hann(count);
  double squares = 0.0;
  for (const double w : window) squares += w * w;
  Spectrum found{1.0 / length_s, std::vector<double>(std::size_t((count - 1) / 2), 0.0)};
  int segments = 0;
  for (const auto& mode : series.modes_waves) {
    segments = add_segments(resample(times, mode, times.front(), step_s, samples), window,
                            found.power_per_hz);
  }
  if (segments == 0) return {};
  for (double& power : found.power_per_hz) power *= 2.0 * step_s / (squares * segments);
  return found;
}

}  // namespace ovws
