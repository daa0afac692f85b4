/// How much of a moving aberration a closed loop takes away, by frequency: from two recordings of
/// what the sensor read, one with the loop open and one with it closed. Pure functions.
#pragma once

#include <optional>
#include <vector>

namespace ovws::study {

/// What was read, frame by frame.
struct Recording {
  std::vector<double> times_s;  ///< rising
  /// [mode][frame], RMS-normalised waves; each as long as times_s.
  std::vector<std::vector<double>> modes_waves;
};

/// Median of the times between neighbours, s. Needs two frames.
double median_interval_s(const std::vector<double>& times_s);

/// Root of the mean over all frames of the sum of squares of all modes, waves.
double rms_waves(const Recording& recording);

/// `values` at begin_s + k * step_s, k = 0 … count-1, linear between neighbours, and the end's
/// value beyond an end. `times_s` rises; both have at least one element and are of the same length.
std::vector<double> resample(const std::vector<double>& times_s, const std::vector<double>& values,
                             double begin_s, double step_s, int count);

/// One-sided: the sum of all power_per_hz times step_hz is the variance.
struct Spectrum {
  double step_hz = 0.0;
  std::vector<double> power_per_hz;  ///< wave^2/Hz; the k-th is at (k + 1) * step_hz
  double hz(std::size_t k) const { return double(k + 1) * step_hz; }
};

/// What a recording of about `seconds` holds three times, each overlapping the next by half; 60 s
/// at most, which longer recordings hold more often.
double segment_s(double seconds);

/// Power summed over the modes, by Welch's method: resampled at the median interval (a little less
/// or more, so that a segment is whole), segments that overlap by half, their means taken away,
/// under Hann windows (Welch, IEEE Trans. Audio 15, 70, 1967). Empty if the recording is shorter
/// than a segment or a segment holds fewer than 8 intervals.
Spectrum spectrum(const Recording& recording, double segment_s);

struct RejectionPoint {
  double hz = 0.0, db = 0.0;
};

/// 10 lg of closed over open from the second frequency (the first lacks what went with the mean) to
/// the last that both have, summed over a third of an octave about each. Both of the same step_hz.
std::vector<RejectionPoint> rejection(const Spectrum& open, const Spectrum& closed);

/// The frequency from which on a rejection is above `level_db`, by a line in log frequency. None:
/// it is above from its begin, or never.
std::optional<double> crossing_hz(const std::vector<RejectionPoint>& rejection, double level_db);

/// A loop's law as core/control/integrator.hpp has it, and how often it steps.
struct LoopLaw {
  double gain = 0.5, leak = 0.0;
  double steps_hz = 0.0;
};

/// What a loop without delay beyond its own step would do:
/// |1 - (1 - leak) z^-1| / |1 - (1 - leak - gain) z^-1| with z = exp(2 pi i f / steps_hz), in dB.
/// NaN above half of steps_hz.
double integrator_db(double hz, const LoopLaw& law);

/// Powers summed from `from_hz` on, below `to_hz`.
struct RejectionBand {
  double from_hz = 0.0, to_hz = 0.0;
  double db = 0.0;             ///< closed over open
  double integrator_db = 0.0;  ///< of LoopLaw, weighted with the open loop's power; may be NaN
};

/// Octaves whose edges are 0.1 Hz times powers of two, those that `rejection` covers wholly.
std::vector<RejectionBand> octave_bands(const Spectrum& open, const Spectrum& closed,
                                        const LoopLaw& law);

}  // namespace ovws::study
