#include "daemon/examine/finding.hpp"

#include <algorithm>
#include <array>

namespace ovws::examine {
namespace {

constexpr std::array kNames{
    SeverityNames{Severity::not_here, "not_here", "not here", "not_here", "not here"},
    SeverityNames{Severity::good, "good", "good", "ok", "ok"},
    SeverityNames{Severity::note, "note", "note", "note", "note"},
    SeverityNames{Severity::warning, "warning", "warning", "warning", "warning"},
    SeverityNames{Severity::bad, "bad", "BAD", "fault", "FAULT"}};

}  // namespace

const SeverityNames& names_of(Severity severity) {
  return kNames[std::size_t(severity)];
}

Severity worst(const Findings& findings) {
  if (findings.empty()) return Severity::good;
  return std::ranges::max_element(findings, {}, &Finding::severity)->severity;
}

Severity severity_of(double value, double note_above, double warning_above, double bad_above) {
  if (value > bad_above) return Severity::bad;
  if (value > warning_above) return Severity::warning;
  return value > note_above ? Severity::note : Severity::good;
}

bool is_command(const std::string& fix) {
  constexpr std::array kPrograms{"sudo", "xrandr", "xset", "systemctl", "ovws"};
  constexpr std::array kNotAsItIs{"FILE", "INTERFACE", "NAME", "…", "...", "<", ", or"};
  const std::string first = fix.substr(0, fix.find(' '));
  return std::ranges::find(kPrograms, first) != kPrograms.end() &&
         std::ranges::none_of(kNotAsItIs,
                              [&](const char* part) { return fix.find(part) != fix.npos; });
}

bool is_for_later(const Finding& finding) {
  return finding.fix.starts_with("ovws setup ") || (finding.needs & kLater) != 0;
}

}  // namespace ovws::examine
