/// Findings about a bench: what ovws doctor, ovws check, the commissioning and the live page
/// report.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "proto/json_part.hpp"

namespace ovws::examine {

/// How bad a finding is; a larger value is worse.
enum class Severity {
  not_here,  ///< cannot be checked on this bench, or not at present
  good,
  note,     ///< good to know
  warning,  ///< works or may work, but not as well as possible
  bad       ///< does not work, or gives wrong measurements
};

struct SeverityNames {
  Severity severity;
  const char* name;         ///< in the documents of check, commissioning and live page
  const char* shown;        ///< to a person
  const char* doctor_name;  ///< in the document of ovws doctor
  const char* doctor_shown;
};
const SeverityNames& names_of(Severity severity);

struct Finding {
  Severity severity = Severity::good;
  std::string text{};  ///< what was found, with its figure; for `not_here`, why it was not
  std::string fix{};   ///< a shell command or a line of the configuration
  nlohmann::json action = nullptr;  ///< what a button of the live page does: see status_questions
  std::string advice{};             ///< what to do, in words
  std::string limit{};              ///< up to where it is good
  double cost_waves = std::numeric_limits<double>::quiet_NaN();  ///< RMS wavefront error that it
                                                                 ///< causes; NaN: not known
  std::string cause{};  ///< name of the finding that explains this one
  std::string name{};   ///< of the question, "camera.packets"
  std::string title{};  ///< of the question, in a report
  unsigned needs = 0;   ///< of the question
};
using Findings = std::vector<Finding>;

inline Finding good(std::string text) {
  return {Severity::good, std::move(text)};
}
inline Finding note(std::string text, std::string fix, nlohmann::json action = nullptr) {
  return {Severity::note, std::move(text), std::move(fix), std::move(action)};
}
inline Finding warning(std::string text, std::string fix, nlohmann::json action = nullptr) {
  return {Severity::warning, std::move(text), std::move(fix), std::move(action)};
}
inline Finding bad(std::string text, std::string fix, nlohmann::json action = nullptr) {
  return {Severity::bad, std::move(text), std::move(fix), std::move(action)};
}
inline Finding not_here(std::string why, std::string fix = {}) {
  return {Severity::not_here, std::move(why), std::move(fix)};
}

inline Finding advised(Severity severity, std::string text, std::string advice) {
  Finding found{severity, std::move(text)};
  found.advice = std::move(advice);
  return found;
}

/// Who asks a question, as bits.
enum Asker : unsigned { kDoctor = 1, kPage = 2, kAll = 3 };
/// What a question needs, and does, as bits.
enum Needs : unsigned {
  kNothing = 0,
  kDaemon = 1,   ///< a daemon that answers
  kCamera = 2,   ///< its camera in use
  kDisplay = 4,  ///< its SLM in use
  kLater = 8     ///< a later step of the commissioning finds the same, and offers the repair
};

/// A question about the bench, which one function judges.
template <class Facts>
struct Question {
  const char* name;
  Finding (*judge)(const Facts&);
  unsigned needs = kNothing;
  unsigned askers = kAll;
  const char* title = "";
};

/// Answers the questions of an asker in their order. `why_not`: why a question cannot be answered,
/// by its needs; empty: it can.
template <class Facts>
Findings answers(std::span<const Question<Facts>> questions, const Facts& facts,
                 unsigned asker = kAll,
                 std::string (*why_not)(const Facts&, unsigned needs) = nullptr) {
  Findings found;
  for (const Question<Facts>& one : questions) {
    if ((one.askers & asker) == 0) continue;
    std::string why = why_not == nullptr ? "" : why_not(facts, one.needs);
    found.push_back(why.empty() ? one.judge(facts) : not_here(std::move(why)));
    found.back().name = one.name;
    found.back().title = one.title;
    found.back().needs = one.needs;
  }
  return found;
}

/// The worst severity.
Severity worst(const Findings& findings);
/// Severity of a value: above the limits note, warning and bad.
Severity severity_of(double value, double note_above, double warning_above, double bad_above);

/// Whether a fix can be run in a shell as it is: it begins with one of a few programs, and contains
/// neither a place to fill in nor an alternative.
bool is_command(const std::string& fix);
/// Whether a later step of the commissioning finds the same, and offers what repairs it.
bool is_for_later(const Finding& finding);

}  // namespace ovws::examine
