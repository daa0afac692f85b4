/// Judges what ovws check has measured.
#pragma once

#include <span>

#include "daemon/examine/check/measured.hpp"
#include "daemon/examine/finding.hpp"

namespace ovws::examine {

/// What the judges read.
struct MeasuredFacts {
  const Measured& measured;
  Stability open;  ///< of the record with the loop open
};

/// Answers all questions of ovws check, and finds which findings explain others.
Findings answers(const Measured& measured);

/// At most five findings that have a fix and no other cause, in the order of their cost in wave.
/// Findings of unknown cost follow, bad ones first.
Findings improve_first(const Findings& findings);

/// Questions about the measurement, and about what the daemon uses.
std::span<const Question<MeasuredFacts>> measurement_questions();
std::span<const Question<MeasuredFacts>> bench_questions();

/// RMS error of the phase that a table shows, in waves: `grey_levels` of a result of lut.get on an
/// SLM with `phase_rad`, a result of lut.run. A constant phase is no error, nor is a phase
/// that falls from step to step, as a linear table gives it on an SLM whose phase falls: a bench
/// that is registered so measures well.
double table_error_waves(const nlohmann::json& grey_levels, const nlohmann::json& phase_rad);

}  // namespace ovws::examine
