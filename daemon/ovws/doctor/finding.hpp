/// What a check of the bench found, as every check tells it.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ovws::doctor {

enum class Verdict {
  ok,
  warning,   ///< works, or may, and not as well as it could
  fault,     ///< does not work, or measures wrongly
  not_here,  ///< cannot be checked on this bench, or not now
};

struct Finding {
  std::string name;  ///< "camera.packets"
  Verdict verdict = Verdict::ok;
  std::string meaning;  ///< one sentence; of `not_here` why
  std::string fix;  ///< a shell command or a line of the configuration; never empty of a warning
                    ///< or a fault
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
