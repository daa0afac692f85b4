#include "daemon/examine/check/judge.hpp"

#include <algorithm>
#include <cmath>

namespace ovws::check {
namespace {

constexpr std::size_t kMostImprovements = 5;

/// Findings that can explain others, the likeliest first, and what they can explain.
constexpr std::array kCauses{"spots", "saturation", "settle", "motion"};
constexpr std::array kEffects{"frames", "response", "noise", "loop", "saturation"};

Finding* find(Findings& findings, const char* name) {
  const auto found = std::ranges::find(findings, name, &Finding::name);
  return found == findings.end() ? nullptr : &*found;
}

/// A cause takes over the cost of what it explains: its command is the one that helps.
void assign_causes(Findings& findings) {
  for (const char* const name : kCauses) {
    Finding* const cause = find(findings, name);
    if (cause == nullptr || cause->verdict < Verdict::warning || !cause->cause.empty()) continue;
    for (const char* const other : kEffects) {
      Finding* const effect = find(findings, other);
      if (effect == nullptr || effect == cause || effect->verdict == Verdict::good) continue;
      if (!std::isnan(effect->cost_waves)) {
        cause->cost_waves = std::fmax(cause->cost_waves, effect->cost_waves);
      }
      effect->cause = name;
    }
    return;
  }
}

}  // namespace

const char* name_of(Verdict verdict) {
  constexpr std::array kNames{"good", "note", "warning", "bad"};
  return kNames[std::size_t(verdict)];
}

Verdict verdict_of(double value, double note_above, double warning_above, double bad_above) {
  if (value > bad_above) return Verdict::bad;
  if (value > warning_above) return Verdict::warning;
  return value > note_above ? Verdict::note : Verdict::good;
}

Findings judge(const Measured& measured) {
  const Facts facts{measured, stability_of(measured.open)};
  Findings findings;
  for (const auto judge_one :
       {judge_response, judge_noise, judge_motion, judge_drift, judge_loop, judge_frames,
        judge_spots, judge_saturation, judge_settle, judge_losses, judge_reference,
        judge_registration, judge_lut, judge_flatness, judge_calibration}) {
    findings.push_back(judge_one(facts));
  }
  assign_causes(findings);
  return findings;
}

Verdict worst(const Findings& findings) {
  Verdict all = Verdict::good;
  for (const Finding& one : findings) all = std::max(all, one.verdict);
  return all;
}

Findings improve_first(const Findings& findings) {
  Findings first;
  for (const Finding& one : findings) {
    if (one.verdict != Verdict::good && !one.fix.empty() && one.cause.empty()) first.push_back(one);
  }
  std::ranges::stable_sort(first, [](const Finding& a, const Finding& b) {
    const bool known_a = !std::isnan(a.cost_waves), known_b = !std::isnan(b.cost_waves);
    if (known_a != known_b) return known_a;
    return known_a ? a.cost_waves > b.cost_waves : a.verdict > b.verdict;
  });
  if (first.size() > kMostImprovements) first.resize(kMostImprovements);
  return first;
}

}  // namespace ovws::check
