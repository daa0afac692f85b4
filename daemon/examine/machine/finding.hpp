/// Finding: the result of one check of the bench.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace ovws::doctor {

enum class Verdict {
  ok,
  warning,   ///< works or may work, but not as well as possible
  fault,     ///< does not work, or gives wrong measurements
  not_here,  ///< cannot be checked on this bench, or not at present
};

struct Finding {
  Verdict verdict = Verdict::ok;
  std::string meaning;  ///< the result in one sentence; for `not_here`, the reason
  std::string fix;      ///< a shell command or a line of the configuration; never empty for a
                        ///< warning or a fault
  std::string name{};   ///< name of the check, e.g. "camera.packets"; set by run_checks
};
using Findings = std::vector<Finding>;

inline Finding ok(std::string meaning) {
  return {Verdict::ok, std::move(meaning), {}};
}
inline Finding warning(std::string meaning, std::string fix) {
  return {Verdict::warning, std::move(meaning), std::move(fix)};
}
inline Finding fault(std::string meaning, std::string fix) {
  return {Verdict::fault, std::move(meaning), std::move(fix)};
}
inline Finding not_here(std::string why, std::string fix = {}) {
  return {Verdict::not_here, std::move(why), std::move(fix)};
}

/// Check of the bench: a function that judges facts, and the name of its finding.
template <class Facts>
struct Check {
  const char* name;
  Finding (*judge)(const Facts&);
};

/// Runs all checks on `facts`. Returns one finding per check, in the order of `checks`.
template <class Facts>
Findings run_checks(std::initializer_list<Check<Facts>> checks, const Facts& facts) {
  Findings found;
  for (const Check<Facts>& check : checks) {
    found.push_back(check.judge(facts));
    found.back().name = check.name;
  }
  return found;
}

}  // namespace ovws::doctor
