/// Power spectra of time series.
#pragma once

#include <cstddef>
#include <vector>

namespace ovws {

/// A time series of modes, frame by frame.
struct ModeSeries {
  std::vector<double> times_s;  ///< strictly increasing
  /// [mode][frame], RMS-normalised waves; each as long as times_s.
  std::vector<std::vector<double>> modes_waves;
};

/// Median frame interval, s. Requires at least two frames.
double median_interval_s(const std::vector<double>& times_s);

/// `values` at begin_s + k * step_s, k = 0 … count-1: the nearest one, whose noise interpolation
/// would reduce; if none is within half a step, linear interpolation; constant beyond the ends.
/// `times_s` increases; both arrays have the same length, at least 1.
std::vector<double> resample(const std::vector<double>& times_s, const std::vector<double>& values,
                             double begin_s, double step_s, int count);

/// One-sided power spectral density: the sum of all power_per_hz times step_hz is the variance.
struct Spectrum {
  double step_hz = 0.0;
  std::vector<double> power_per_hz;  ///< wave^2/Hz; k-th value: at the frequency (k + 1) * step_hz
  double hz(std::size_t k) const { return double(k + 1) * step_hz; }
};

/// Segment length for a series of about `seconds`: three segments that overlap by half, but at
/// most 60 s, so that longer series have more segments.
double segment_s(double seconds);

/// Power spectral density by Welch's method (IEEE Trans. Audio 15, 70, 1967), summed over the
/// modes, with segments of `length_s`. The series is resampled at about the median frame interval,
/// so that a segment is a whole number of intervals. Segments overlap by half, have their means
/// removed and get Hann windows. Empty if the series is shorter than a segment, or if a segment has
/// fewer than 8 intervals.
Spectrum spectrum(const ModeSeries& series, double length_s);

}  // namespace ovws
