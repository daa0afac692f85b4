/// What `ovws check` measures on a bench as plain values, and what is computed from them.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ovws/study/statistics.hpp"
#include "daemon/shared/lost_spots.hpp"

namespace ovws::examine {

constexpr double kPokeWaves = 0.1;  ///< RMS of a mode that is shown and read back

/// One settled frame of the stream `wavefront`.
struct Frame {
  double t_s = 0.0;  ///< arrival, from an arbitrary begin
  bool valid = false;
  double saturated = 0.0;      ///< fraction of the spots
  std::vector<double> waves;   ///< coefficients; empty if not valid
  std::vector<double> sigmas;  ///< standard errors, waves; empty if the frame states none
};

/// One mode, shown twice with +a and twice with -a in the order + - - +, which cancels a drift.
struct Poke {
  int j = 0;
  bool read = false;              ///< false: too few frames were valid
  int settled = 0, valid = 0;     ///< frames while it was shown
  std::vector<study::Mean> gain;  ///< of each measured mode, wave per wave shown
  /// Error of the first frame after a change that counted as settled, waves; mean of the four
  /// changes, against the mean of the later frames.
  double first_error_waves = 0.0;
};

struct Response {
  std::vector<int> modes_j;  ///< the measured modes, order of Poke::gain
  std::vector<Poke> pokes;
  cli::SpotCounts spots;  ///< of all frames while modes were shown
  std::string reason;     ///< why the daemon took frames of an unread mode as not valid; or empty
};

/// Frames of some seconds in a row, without a change by this program.
struct Record {
  std::vector<int> modes_j;
  std::vector<Frame> frames;  ///< settled ones, by increasing t_s
  int received = 0;           ///< all frames, settled or not
  cli::SpotCounts spots{};    ///< of the same time
  double seconds() const {
    return frames.size() < 2 ? 0.0 : frames.back().t_s - frames.front().t_s;
  }
};

/// Result of a job, or why there is none.
struct JobResult {
  nlohmann::json result;  ///< null: not measured
  std::string reason;     ///< why not
};

struct LoopResult {
  Record record;        ///< after the loop has converged
  nlohmann::json loop;  ///< loop.get at the end of the record; null: not measured
  std::string reason;   ///< why it was not measured, or why the loop opened
  bool failed = false;  ///< the loop was closed, and opened by itself
};

struct Measured {
  std::string version;
  std::int64_t t_ns = 0;  ///< begin, UNIX epoch
  bool quick = false;
  // Answers of the daemon before the check.
  nlohmann::json status, sensor, reference, registration, lut, flatness, calibration, config;
  nlohmann::json counters_after;  ///< of system.status after the open-loop record
  JobResult settle;               ///< of slm.settle
  JobResult lut_run;              ///< of lut.run, if no table was measured before
  Response response;
  Record open;
  LoopResult loop;
};

// Response of the bench to each mode: what is read back of what the SLM shows.

/// Frames of one hologram. `first`: the first settled and valid frame; `rest`: the later frames
/// that count, all measured in the same way. All have the same modes.
struct Shown {
  Frame first;
  std::vector<Frame> rest;
  int settled = 0, valid = 0;  ///< frames that came, whether they count or not
};

/// The response to mode j, shown with +a, -a, -a, +a. Standard errors are the larger of those by
/// the scatter of the frames and by the difference of the two pairs. Not read if a hologram has no
/// frames.
Poke poke_of(int j, const std::array<Shown, 4>& shown);

/// How far the reading of a poke is from what was shown, waves: root sum square over the measured
/// modes, with tilts, of the error that its standard errors do not explain.
double error_waves(const Poke& poke, const std::vector<int>& modes_j);

/// The gain of the poked mode itself; NaN if the sensor does not measure it.
study::Mean slope_of(const Poke& poke, const std::vector<int>& modes_j);
/// Root sum square of the gains of all other modes.
double crosstalk_of(const Poke& poke, const std::vector<int>& modes_j);

// Noise, motion and drift of the coefficients in a record.

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

/// Sum of the squares of a frame's coefficients without tilts.
double square_waves(const Frame& frame, const std::vector<int>& modes_j);
/// Root mean square over the valid frames of the coefficients without tilts; NaN if there is none.
double rms_waves(const Record& record);

}  // namespace ovws::examine
