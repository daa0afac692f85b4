/// ovws doctor: checks the bench and prints a fix for each problem.
#include "daemon/examine/machine/doctor.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/ovws/cli/setup.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using examine::Finding;
using examine::Findings;
using examine::Severity;

constexpr std::array kSeverities{Severity::bad, Severity::warning, Severity::note, Severity::good,
                                 Severity::not_here};

std::int64_t count(const Findings& found, Severity severity) {
  return std::ranges::count(found, severity, &Finding::severity);
}

void print_findings_json(const Findings& found) {
  nlohmann::json findings = nlohmann::json::array();
  for (const Finding& one : found) {
    findings.push_back({{"name", one.name},
                        {"verdict", examine::names_of(one.severity).doctor_name},
                        {"meaning", one.text},
                        {"fix", one.fix.empty() ? nlohmann::json() : nlohmann::json(one.fix)}});
  }
  nlohmann::json counts;
  for (const Severity one : kSeverities) {
    counts[examine::names_of(one).doctor_name] = count(found, one);
  }
  const nlohmann::json document{{"schema", "ovws.doctor/1"},
                                {"version", OVWS_VERSION},
                                {"counts", std::move(counts)},
                                {"findings", std::move(findings)}};
  print("{}\n", json_text(document));
}

void print_findings(const Findings& found) {
  for (const Finding& one : found) {
    print("{:<9} {:<21} {}\n", examine::names_of(one.severity).doctor_shown, one.name, one.text);
    if (!one.fix.empty()) print("{:<9} {:<21}   fix: {}\n", "", "", one.fix);
  }
  std::string summary;
  for (const Severity one : kSeverities) {
    summary += fmt::format("{}{} {}", summary.empty() ? "" : ", ", count(found, one),
                           examine::names_of(one).doctor_shown);
  }
  print("{}\n", summary);
}

examine::DaemonFacts ask_daemon(Common common, const std::string& endpoint) {
  common.endpoint = endpoint;
  examine::DaemonFacts facts;
  facts.endpoint = endpoint;
  facts.own_version = OVWS_VERSION;
  auto status = call(common, "system.status", nlohmann::json::object());
  if (!status) {
    facts.refused = status.error().answered;
    facts.why = message_of(status.error());
    return facts;
  }
  facts.status = std::move(*status);
  facts.config = call(common, "config.get", nlohmann::json::object()).value_or(nullptr);
  facts.wavefront = newest_wavefront(common).value_or(nullptr);
  if (!examine::shows_holograms(facts)) return facts;
  facts.why_no_levels = examine::why_not_verify(facts);
  if (!facts.why_no_levels.empty()) return facts;
  if (auto levels = call(common, "slm.verify", nlohmann::json::object())) {
    facts.levels = std::move(*levels);
  } else {
    facts.why_no_levels = message_of(levels.error());
  }
  return facts;
}

}  // namespace

Findings examine_bench(const Common& common, const std::string& config_path,
                       const std::string& endpoint) {
  return examine::examine_all(config_path, endpoint, [&common](const std::string& where) {
    return ask_daemon(common, where);
  });
}

int check_bench(const Common& common, const std::string& config_path, const std::string& endpoint) {
  const Findings found = examine_bench(common, config_path, endpoint);
  common.json ? print_findings_json(found) : print_findings(found);
  return examine::worst(found) == Severity::bad ? kError : kOk;
}

}  // namespace ovws::cli
