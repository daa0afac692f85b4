/// ovws doctor: checks the bench and prints a fix for each problem.
#include "daemon/ovws/doctor/doctor.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::cli {
namespace {

using doctor::Finding;
using doctor::Findings;
using doctor::Verdict;

struct Word {
  Verdict verdict;
  const char* text;
  const char* key;  ///< in JSON
};
constexpr std::array kWords{
    Word{Verdict::fault, "FAULT", "fault"}, Word{Verdict::warning, "warning", "warning"},
    Word{Verdict::ok, "ok", "ok"}, Word{Verdict::not_here, "not here", "not_here"}};

const Word& word_of(Verdict verdict) {
  return *std::ranges::find(kWords, verdict, &Word::verdict);
}

std::int64_t count(const Findings& found, Verdict verdict) {
  return std::ranges::count(found, verdict, &Finding::verdict);
}

void print_json(const Findings& found) {
  nlohmann::json findings = nlohmann::json::array();
  for (const Finding& one : found) {
    nlohmann::json fix;
    if (!one.fix.empty()) fix = one.fix;
    findings.push_back({{"name", one.name},
                        {"verdict", word_of(one.verdict).key},
                        {"meaning", one.meaning},
                        {"fix", std::move(fix)}});
  }
  nlohmann::json counts;
  for (const Word& word : kWords) counts[word.key] = count(found, word.verdict);
  const nlohmann::json document{{"schema", "ovws.doctor/1"},
                                {"version", OVWS_VERSION},
                                {"counts", std::move(counts)},
                                {"findings", std::move(findings)}};
  print("{}\n", document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

void print_text(const Findings& found) {
  for (const Finding& one : found) {
    print("{:<9} {:<21} {}\n", word_of(one.verdict).text, one.name, one.meaning);
    if (!one.fix.empty()) print("{:<9} {:<21}   fix: {}\n", "", "", one.fix);
  }
  std::string summary;
  for (const Word& word : kWords) {
    summary +=
        fmt::format("{}{} {}", summary.empty() ? "" : ", ", count(found, word.verdict), word.text);
  }
  print("{}\n", summary);
}

doctor::DaemonFacts ask(Common common, const std::string& endpoint) {
  common.endpoint = endpoint;
  doctor::DaemonFacts facts;
  facts.endpoint = endpoint;
  facts.own_version = OVWS_VERSION;
  if (auto status = call(common, "system.status", nlohmann::json::object())) {
    facts.status = std::move(*status);
  } else {
    facts.refused = status.error().answered;
    facts.why = status.error().error.value("message", "no reason given");
  }
  return facts;
}

}  // namespace

void add_doctor(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("doctor",
                                     "check this bench in a few seconds and print a fix for each "
                                     "problem; read-only, works with or "
                                     "without a daemon, needs no root");
  command->footer(
      "Checks the configuration, the camera and its link, the SLM's output, the state folder,\n"
      "the real-time limits and the clock of this machine, and the daemon if one is running.\n"
      "Run it as the daemon's user, on its display:\n"
      "  sudo -u ovws DISPLAY=:0 XAUTHORITY=/var/lib/ovws/xauthority ovws doctor\n\n"
      "Each finding is FAULT (does not work, or measures wrongly), warning (works or may work, "
      "but\n"
      "worse than it could), ok, or not here (cannot be checked, with the reason). \"fix:\" is "
      "followed\n"
      "by a shell command or a line for the configuration file.\n"
      "--json prints one document: {\"schema\", \"version\", \"counts\": {\"fault\", …}, "
      "\"findings\":\n"
      "[{\"name\", \"verdict\": \"fault\" | \"warning\" | \"ok\" | \"not_here\", \"meaning\", "
      "\"fix\"}]}.\n\n"
      "Exit codes: 0 no fault; 1 at least one fault; 2 the command line is wrong.");
  auto path = std::make_shared<std::string>();
  command->add_option(
      "--config,-c", *path,
      "configuration file (default: /etc/ovws/ovwsd.json, or every key's default without it)");
  const CLI::Option* const given = app.get_option("--endpoint");
  command->callback([&common, &status, path, given] {
    const std::string endpoint = given->count() > 0 ? common.endpoint : "";
    const Findings found = doctor::examine(
        *path, endpoint, [&common](const std::string& where) { return ask(common, where); });
    if (common.json) {
      print_json(found);
    } else {
      print_text(found);
    }
    status = count(found, Verdict::fault) > 0 ? kError : kOk;
  });
}

}  // namespace ovws::cli
