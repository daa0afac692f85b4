/// Findings of `ovws check`: verdicts with their limits.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/examine/check/measured.hpp"
#include "daemon/examine/check/stability.hpp"

namespace ovws::check {

enum class Verdict { good, note, warning, bad };
const char* name_of(Verdict verdict);

struct Finding {
  std::string name{};   ///< "response", "noise", …
  std::string title{};  ///< for people
  Verdict verdict = Verdict::good;
  std::string text{};                   ///< what was measured, one or two sentences
  std::string limit{};                  ///< what the verdict is good for
  std::string fix{};                    ///< command that improves it; may be empty
  double cost_waves = study::kUnknown;  ///< RMS wavefront error that it causes; NaN: not known
  std::string cause{};                  ///< name of the finding that explains this one; empty: none
};
using Findings = std::vector<Finding>;

/// Judges a bench. One finding per subject, in a fixed order.
Findings judge(const Measured& measured);

/// The worst verdict.
Verdict worst(const Findings& findings);

/// At most five findings that have a fix and no other cause, in the order of their cost in wave.
/// Findings of unknown cost follow, bad ones first.
Findings improve_first(const Findings& findings);

}  // namespace ovws::check
