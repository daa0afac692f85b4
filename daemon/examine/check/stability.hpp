/// Noise, motion and drift of the coefficients in a record.
#pragma once

#include <vector>

#include "daemon/examine/check/measured.hpp"

namespace ovws::examine {

/// A mode in a record; all values in waves.
struct ModeStability {
  int j = 0;
  double mean = 0.0;
  /// Noise of one frame, by third differences, which suppress motion slower than the frames.
  double noise = 0.0;
  double stated = study::kUnknown;  ///< RMS of the standard errors that the frames state
  double spread = 0.0;              ///< standard deviation over the record
  double drift = 0.0;               ///< change over the record, by a straight line
};

struct Stability {
  std::vector<ModeStability> modes;
  // Root sum squares over all modes, waves.
  double noise = 0.0;
  double stated = study::kUnknown;
  double drift = 0.0;
  double motion = 0.0;         ///< of the spread that neither noise nor the straight line explains
  double offset = 0.0;         ///< of the means, without tilts: distance from the reference
  double frequency_hz = 0.0;   ///< of the strongest line of the spectrum; 0: no line stands out
  int strongest_j = 0;         ///< mode that moves most
  double frame_rate_hz = 0.0;  ///< of the usable frames
  bool usable = false;         ///< false: fewer than kMinFrames frames are valid
};

constexpr int kMinFrames = 16;

Stability stability_of(const Record& record);

/// Mean of each second of the record, by mode and second: times_s and [mode][second].
struct Seconds {
  std::vector<double> times_s;
  std::vector<std::vector<double>> waves;
};
Seconds seconds_of(const Record& record);

/// Allan deviation of the root sum square over the modes: how well a mean over `times_s` repeats.
struct AllanCurve {
  std::vector<double> times_s, waves;
};
AllanCurve allan_of(const Record& record);

/// Root mean square over the valid frames of the coefficients without tilts; NaN if there is none.
double rms_waves(const Record& record);

}  // namespace ovws::examine
