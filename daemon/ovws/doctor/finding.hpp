/// Finding: the result of one check of the bench.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ovws::doctor {

enum class Verdict {
  ok,
  warning,   ///< works or may work, but worse than it could
  fault,     ///< does not work, or gives wrong measurements
  not_here,  ///< cannot be checked on this bench, or not at present
};

struct Finding {
  std::string name;  ///< "camera.packets"
  Verdict verdict = Verdict::ok;
  std::string meaning;  ///< one sentence; for `not_here` the reason
  std::string fix;      ///< a shell command or a line of the configuration; never empty for a
                        ///< warning or a fault
};
using Findings = std::vector<Finding>;

inline Finding ok(std::string name, std::string meaning) {
  return {std::move(name), Verdict::ok, std::move(meaning), {}};
}
inline Finding warning(std::string name, std::string meaning, std::string fix) {
  return {std::move(name), Verdict::warning, std::move(meaning), std::move(fix)};
}
inline Finding fault(std::string name, std::string meaning, std::string fix) {
  return {std::move(name), Verdict::fault, std::move(meaning), std::move(fix)};
}
inline Finding not_here(std::string name, std::string why, std::string fix = {}) {
  return {std::move(name), Verdict::not_here, std::move(why), std::move(fix)};
}

}  // namespace ovws::doctor
