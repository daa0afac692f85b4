#include "daemon/ovws/text/modes_text.hpp"

#include <algorithm>
#include <sstream>

#include "core/base/number_text.hpp"
#include "daemon/ovws/text/mode_names.hpp"

namespace ovws::cli {
namespace {

/// Without the blanks at the ends and beside a comma.
std::string without_blanks(const std::string& text) {
  std::string kept;
  for (const char c : text) {
    if (c != ' ' && c != '\t') {
      if (c == ',') kept.resize(kept.find_last_not_of(' ') + 1);
      kept += c;
    } else if (!kept.empty() && kept.back() != ' ' && kept.back() != ',') {
      kept += ' ';
    }
  }
  kept.resize(kept.find_last_not_of(' ') + 1);
  return kept;
}

Result<Mode> parse_mode(const std::string& part, ZernikeNorm norm) {
  const auto colon = part.find(':');
  const auto waves =
      colon == part.npos ? std::nullopt : finite_number(without_blanks(part.substr(colon + 1)));
  if (!waves) {
    return fail(Errc::invalid, "modes", "\"" + part + "\" does not have the form n,m:waves");
  }
  const auto j = mode_of(without_blanks(part.substr(0, colon)));
  if (!j) return fail(j.error());
  return Mode{*j, norm == ZernikeNorm::unit ? *waves / zernike_rms_factor(*j) : *waves};
}

}  // namespace

Result<std::vector<Mode>> parse_modes(const std::string& text, ZernikeNorm norm) {
  std::vector<Mode> modes;
  if (!text.empty() && text.find_first_not_of(" \t;") == std::string::npos) {
    return fail(
        Errc::invalid, "modes",
        "\"" + text + "\" contains no mode: give n,m:waves, e.g. 2,-2:0.5, or omit --modes");
  }
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ';');) {
    if (part.find_first_not_of(" \t") == std::string::npos) continue;
    auto mode = parse_mode(part, norm);
    if (!mode) return fail(mode.error());
    const auto same = [&](const Mode& other) { return other.j == mode->j; };
    if (std::any_of(modes.begin(), modes.end(), same)) {
      return fail(Errc::invalid, "modes", "\"" + part + "\": this mode is given twice");
    }
    modes.push_back(*mode);
  }
  return modes;
}

}  // namespace ovws::cli
