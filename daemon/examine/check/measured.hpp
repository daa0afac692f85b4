/// What `ovws check` measures on a bench, as plain values.
#pragma once

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

}  // namespace ovws::examine
