#include "daemon/examine/check/judge.hpp"

#include <algorithm>
#include <cmath>

namespace ovws::examine {
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
    if (cause == nullptr || cause->severity < Severity::warning || !cause->cause.empty()) continue;
    for (const char* const other : kEffects) {
      Finding* const effect = find(findings, other);
      if (effect == nullptr || effect == cause || effect->severity == Severity::good) continue;
      if (!std::isnan(effect->cost_waves)) {
        cause->cost_waves = std::fmax(cause->cost_waves, effect->cost_waves);
      }
      effect->cause = name;
    }
    return;
  }
}

}  // namespace

Findings answers(const Measured& measured) {
  const MeasuredFacts facts{measured, stability_of(measured.open)};
  Findings findings;
  for (const auto questions : {measurement_questions(), bench_questions()}) {
    std::ranges::move(answers<MeasuredFacts>(questions, facts), std::back_inserter(findings));
  }
  assign_causes(findings);
  return findings;
}

Findings improve_first(const Findings& findings) {
  Findings first;
  for (const Finding& one : findings) {
    if (one.severity != Severity::good && !one.fix.empty() && one.cause.empty())
      first.push_back(one);
  }
  std::ranges::stable_sort(first, [](const Finding& a, const Finding& b) {
    const bool known_a = !std::isnan(a.cost_waves), known_b = !std::isnan(b.cost_waves);
    if (known_a != known_b) return known_a;
    return known_a ? a.cost_waves > b.cost_waves : a.severity > b.severity;
  });
  if (first.size() > kMostImprovements) first.resize(kMostImprovements);
  return first;
}

}  // namespace ovws::examine
