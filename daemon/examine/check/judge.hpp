/// The parts of `judge`: one function for each finding.
#pragma once

#include <array>

#include "daemon/examine/check/finding.hpp"

namespace ovws::check {

/// What the judges read.
struct Facts {
  const Measured& measured;
  Stability open;  ///< of the record with the loop open
};

/// Worst of a value: good up to `good`, then note, warning and bad above the further limits.
Verdict verdict_of(double value, double note_above, double warning_above, double bad_above);

// Of the measurement.
Finding judge_frames(const Facts& facts);
Finding judge_spots(const Facts& facts);
Finding judge_saturation(const Facts& facts);
Finding judge_settle(const Facts& facts);
Finding judge_response(const Facts& facts);
Finding judge_noise(const Facts& facts);
Finding judge_motion(const Facts& facts);
Finding judge_drift(const Facts& facts);
Finding judge_loop(const Facts& facts);
Finding judge_losses(const Facts& facts);

// Of what the daemon uses.
Finding judge_reference(const Facts& facts);
Finding judge_registration(const Facts& facts);
Finding judge_lut(const Facts& facts);
Finding judge_flatness(const Facts& facts);
Finding judge_calibration(const Facts& facts);

/// RMS error of the phase that a table shows, in waves: `grey_levels` of a result of lut.get on an
/// SLM with `phase_rad`, a result of lut.run. A constant phase is no error, nor is a phase
/// that falls from step to step, as a linear table gives it on an SLM whose phase falls: a bench
/// that is registered so measures well.
double table_error_waves(const nlohmann::json& grey_levels, const nlohmann::json& phase_rad);

}  // namespace ovws::check
