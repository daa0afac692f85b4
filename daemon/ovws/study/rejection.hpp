/// Disturbance rejection of a closed loop by frequency, from two recordings of the sensor's modes:
/// loop open and loop closed. Pure functions.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ovws/study/figure.hpp"

namespace ovws::study {

/// A time series of modes, frame by frame.
struct Recording {
  std::vector<double> times_s;  ///< strictly increasing
  /// [mode][frame], RMS-normalised waves; each as long as times_s.
  std::vector<std::vector<double>> modes_waves;
};

/// Median frame interval, s. Requires at least two frames.
double median_interval_s(const std::vector<double>& times_s);

/// RMS over all frames of the root sum square of all modes, waves.
double rms_waves(const Recording& recording);

/// Linear interpolation of `values` at begin_s + k * step_s, k = 0 … count-1; constant beyond the
/// ends. `times_s` increases; both arrays have the same length, at least 1.
std::vector<double> resample(const std::vector<double>& times_s, const std::vector<double>& values,
                             double begin_s, double step_s, int count);

/// One-sided power spectral density: the sum of all power_per_hz times step_hz is the variance.
struct Spectrum {
  double step_hz = 0.0;
  std::vector<double> power_per_hz;  ///< wave^2/Hz; k-th value: at the frequency (k + 1) * step_hz
  double hz(std::size_t k) const { return double(k + 1) * step_hz; }
};

/// Segment length for a recording of about `seconds`: three segments that overlap by half, but at
/// most 60 s, so that longer recordings have more segments.
double segment_s(double seconds);

/// Power spectral density by Welch's method (IEEE Trans. Audio 15, 70, 1967), summed over the
/// modes. The series is resampled at about the median frame interval, so that a segment is a whole
/// number of intervals. Segments overlap by half, have their means removed and get Hann windows.
/// Empty if the recording is shorter than a segment, or if a segment has fewer than 8 intervals.
Spectrum spectrum(const Recording& recording, double segment_s);

struct RejectionPoint {
  double hz = 0.0, db = 0.0;
};

/// Rejection in dB: 10 lg of closed over open power, each summed over a third of an octave about
/// the frequency. Starts at the second frequency, because removing the mean reduces the first. Ends
/// at the last common frequency. Both spectra must have the same step_hz.
std::vector<RejectionPoint> rejection(const Spectrum& open, const Spectrum& closed);

/// Crossing frequency: the first one at which the rejection rises above `level_db`, interpolated in
/// log frequency. None: the rejection is above the level from the start, or never.
std::optional<double> crossing_hz(const std::vector<RejectionPoint>& rejection, double level_db);

/// Control law of core/control/integrator.hpp, and its step rate.
struct LoopLaw {
  double gain = 0.5, leak = 0.0;
  double steps_hz = 0.0;
};

/// Error transfer function of a leaky-integrator loop without delay beyond its own step:
/// |1 - (1 - leak) z^-1| / |1 - (1 - leak - gain) z^-1| with z = exp(2 pi i f / steps_hz), in dB.
/// NaN above half of steps_hz.
double integrator_db(double hz, const LoopLaw& law);

/// Rejection in a band from `from_hz` (included) to `to_hz` (excluded).
struct RejectionBand {
  double from_hz = 0.0, to_hz = 0.0;
  double db = 0.0;             ///< rejection: closed over open power
  double integrator_db = 0.0;  ///< by LoopLaw, weighted with the open loop's power; may be NaN
};

/// Octave bands with edges at 0.1 Hz times powers of two that lie completely within `rejection`.
std::vector<RejectionBand> octave_bands(const Spectrum& open, const Spectrum& closed,
                                        const LoopLaw& law);

/// A recording, and the counts of received and lost frames.
struct RecordedLoop {
  Recording recording;
  int received = 0;           ///< frames whose message arrived
  int lost = 0;               ///< frames without a message
  bool device_clock = true;   ///< times_s are device time stamps; false: arrival times
  std::string why_not_valid;  ///< reason of the last unusable frame; empty: none
};

struct RejectionMeasured {
  std::vector<int> modes_j;  ///< modes of the open and the closed recording
  RecordedLoop open, closed;
  nlohmann::json loop;     ///< result of loop.get with the loop closed
  double steps_hz = 0.0;   ///< step rate of the loop during the recording
  double segment_s = 0.0;  ///< segment length of the spectra
};

struct RejectionFound {
  Spectrum open, closed;
  LoopLaw law;
  std::vector<RejectionPoint> rejection;
  std::vector<RejectionBand> bands;
};

RejectionFound find_rejection(const RejectionMeasured& measured);

/// The figures "rejection-spectra" and "rejection".
std::vector<Figure> rejection_figures(const RejectionFound& found);

/// JSON summary; unknown numbers are null.
nlohmann::json rejection_summary(const RejectionMeasured& measured, const RejectionFound& found);

/// Formats a result of rejection_summary as text.
std::string rejection_text(const nlohmann::json& summary);

}  // namespace ovws::study
