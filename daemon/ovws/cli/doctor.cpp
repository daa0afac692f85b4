/// ovws doctor: checks the bench and prints a fix for each problem.
#include "daemon/examine/machine/doctor.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {
namespace {

using examine::Finding;
using examine::Findings;
using examine::Severity;

struct DoctorOptions {
  std::string config_path;
  const CLI::Option* endpoint = nullptr;  ///< if it is given, this daemon is asked
};

constexpr std::array kSeverities{Severity::bad, Severity::warning, Severity::note, Severity::good,
                                 Severity::not_here};

std::int64_t count(const Findings& found, Severity severity) {
  return std::ranges::count(found, severity, &Finding::severity);
}

nlohmann::json document_of(const Findings& found) {
  nlohmann::json findings = nlohmann::json::array();
  for (const Finding& one : found) {
    findings.push_back({{"name", one.name},
                        {"verdict", examine::names_of(one.severity).doctor_name},
                        {"meaning", one.text},
                        {"fix", text_or_null(one.fix)}});
  }
  nlohmann::json counts;
  for (const Severity one : kSeverities) {
    counts[examine::names_of(one).doctor_name] = count(found, one);
  }
  return {{"schema", "ovws.doctor/1"},
          {"version", OVWS_VERSION},
          {"counts", std::move(counts)},
          {"findings", std::move(findings)}};
}

std::string findings_text(const Findings& found) {
  std::string text, summary;
  for (const Finding& one : found) {
    text += fmt::format("{:<9} {:<21} {}\n", examine::names_of(one.severity).doctor_shown, one.name,
                        one.text);
    if (!one.fix.empty()) text += fmt::format("{:<9} {:<21}   fix: {}\n", "", "", one.fix);
  }
  for (const Severity one : kSeverities) {
    summary += fmt::format("{}{} {}", summary.empty() ? "" : ", ", count(found, one),
                           examine::names_of(one).doctor_shown);
  }
  return text + summary;
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

int diagnose(const Common& common, const DoctorOptions& options) {
  const Findings found = examine_bench(common, options.config_path, options.endpoint);
  print_result(common, document_of(found), findings_text(found));
  return examine::worst(found) == Severity::bad ? kError : kOk;
}

}  // namespace

Findings examine_bench(const Common& common, const std::string& config_path,
                       const CLI::Option* endpoint) {
  return examine::examine_all(
      config_path, endpoint->count() > 0 ? common.endpoint : "",
      [&common](const std::string& where) { return ask_daemon(common, where); });
}

void add_doctor(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(app, common, status, "doctor",
                                        "check this bench in a few seconds and print a fix for "
                                        "each problem; read-only, works with or without a daemon, "
                                        "needs no root",
                                        diagnose);
  command.footer(
      "Checks the configuration, the camera and its link, the SLM's output, the state folder,\n"
      "the real-time limits and the clock of this machine, and the daemon if one is running.\n"
      "It judges the settings that the daemon uses, or a file; \"configuration\" says which.\n"
      "Run it as the daemon's user, on its display:\n"
      "  sudo -u ovws DISPLAY=:0 XAUTHORITY=/var/lib/ovws/xauthority ovws doctor\n\n"
      "Each finding is FAULT (does not work, or measures wrongly), warning (works or may work, "
      "but\n"
      "worse than it could), note (worth knowing), ok, or not here (cannot be checked, with the\n"
      "reason). \"fix:\" is followed by a shell command or a line for the configuration file.\n"
      "--json prints one document: {\"schema\", \"version\", \"counts\": {\"fault\", …}, "
      "\"findings\":\n"
      "[{\"name\", \"verdict\": \"fault\" | \"warning\" | \"note\" | \"ok\" | \"not_here\", "
      "\"meaning\",\n"
      "\"fix\"}]}.\n\n"
      "Exit codes: 0 no fault; 1 at least one fault; 2 the command line is wrong.");
  command.add_option(
      "--config,-c", options.config_path,
      "configuration file to judge (default: the settings that the daemon on this machine uses; if "
      "none answers, /etc/ovws/ovwsd.json; if there is none, every key's default)");
  options.endpoint = app.get_option("--endpoint");
}

}  // namespace ovws::cli
