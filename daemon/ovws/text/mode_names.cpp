#include "daemon/ovws/text/mode_names.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <sstream>

#include "core/base/number_text.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

using Words = std::set<std::string>;

Words words_of(std::string_view name) {
  Words words;
  std::string word;
  for (const char c : name) {
    if (c == '-' || c == '_' || c == ' ') {
      if (!word.empty()) words.insert(word);
      word.clear();
    } else {
      word += char(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  if (!word.empty()) words.insert(word);
  return words;
}

/// Whether the text is meant as a number: j or n,m.
bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789,-+") == std::string_view::npos;
}

Result<int> mode_of_number(std::string_view text) {
  const auto comma = text.find(',');
  if (comma == std::string_view::npos) {
    const auto j = number_from<int>(text);
    if (j && *j >= 0 && *j <= kMaxZernikeIndex) return *j;
    return fail(
        Errc::invalid, "modes",
        fmt::format("{} is not a mode: j is a whole number from 0 to {}", text, kMaxZernikeIndex));
  }
  const auto n = number_from<int>(text.substr(0, comma)),
             m = number_from<int>(text.substr(comma + 1));
  const auto j = n && m ? checked_osa_index(*n, *m) : std::nullopt;
  if (j) return *j;
  return fail(Errc::invalid, "modes",
              fmt::format("{} is not a Zernike mode: |m| <= n <= 20 with n - |m| even", text));
}

tl::unexpected<Error> no_mode(std::string_view text) {
  std::vector<std::string> known = mode_names();
  for (const std::string& name : mode_names()) {
    for (const std::string& word : words_of(name)) known.push_back(word);
  }
  const auto near = nearest_name(text, known);
  return fail(
      Errc::invalid, "modes",
      fmt::format("\"{}\" is not a mode{} give j, n,m, or a name: {}", text,
                  near ? "; did you mean " + *near + "?" : ";", fmt::join(mode_names(), ", ")));
}

}  // namespace

const std::vector<std::string>& mode_names() {
  static const std::vector<std::string> kAll = [] {
    std::vector<std::string> all;
    for (int j = 0; !zernike_name(j).starts_with("Z("); ++j) {
      all.push_back(zernike_name(j));
      std::replace(all.back().begin(), all.back().end(), ' ', '-');
    }
    return all;
  }();
  return kAll;
}

std::size_t longest_name(const std::vector<int>& modes_j) {
  std::size_t longest = 0;
  for (const int j : modes_j) longest = std::max(longest, zernike_name(j).size());
  return longest;
}

Result<int> mode_of(std::string_view text) {
  if (is_number(text)) return mode_of_number(text);
  const Words given = words_of(text);
  std::vector<std::string> found;
  int last = 0;
  for (int j = 0; j < int(mode_names().size()) && !given.empty(); ++j) {
    const Words name = words_of(mode_names()[std::size_t(j)]);
    if (name == given) return j;
    if (name.contains("secondary") && !given.contains("secondary")) continue;
    if (!std::includes(name.begin(), name.end(), given.begin(), given.end())) continue;
    found.push_back(mode_names()[std::size_t(j)]);
    last = j;
  }
  if (found.size() == 1) return last;
  if (found.empty()) return no_mode(text);
  return fail(Errc::invalid, "modes",
              fmt::format("\"{}\" is ambiguous: {}", text, fmt::join(found, " or ")));
}

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
