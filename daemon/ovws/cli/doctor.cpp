/// ovws doctor: checks the bench and prints a fix for each problem.
#include "daemon/examine/machine/doctor.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/ovws/cli/setup.hpp"
#include "daemon/shared/client.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using doctor::Finding;
using doctor::Findings;
using doctor::Verdict;

struct Word {
  Verdict verdict;
  const char* text;
  const char* key;  ///< name of the result in JSON output
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

void print_findings_json(const Findings& found) {
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
  print("{}\n", json_text(document));
}

void print_findings(const Findings& found) {
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

doctor::DaemonFacts ask_daemon(Common common, const std::string& endpoint) {
  common.endpoint = endpoint;
  doctor::DaemonFacts facts;
  facts.endpoint = endpoint;
  facts.own_version = OVWS_VERSION;
  if (auto status = call(common, "system.status", nlohmann::json::object())) {
    facts.status = std::move(*status);
    if (const auto in_use = call(common, "config.get", nlohmann::json::object())) {
      if (const auto config = parse_config(json_text(*in_use))) facts.config = *config;
    }
    const auto wavefront = newest_wavefront(common);
    if (wavefront && wavefront->is_object()) {
      facts.saturated = wavefront->at("saturated").get<double>();
    }
    if (!doctor::shows_holograms(facts)) return facts;
    facts.why_no_levels = doctor::why_not_verify(facts);
    if (!facts.why_no_levels.empty()) return facts;
    if (auto levels = call(common, "slm.verify", nlohmann::json::object())) {
      facts.levels = std::move(*levels);
    } else {
      facts.why_no_levels = levels.error().error.value("message", "no reason given");
    }
  } else {
    facts.refused = status.error().answered;
    facts.why = status.error().error.value("message", "no reason given");
  }
  return facts;
}

}  // namespace

doctor::Findings examine_bench(const Common& common, const std::string& config_path,
                               const std::string& endpoint) {
  return doctor::examine(config_path, endpoint,
                         [&common](const std::string& where) { return ask_daemon(common, where); });
}

int check_bench(const Common& common, const std::string& config_path, const std::string& endpoint) {
  const Findings found = examine_bench(common, config_path, endpoint);
  if (common.json) {
    print_findings_json(found);
  } else {
    print_findings(found);
  }
  return count(found, Verdict::fault) > 0 ? kError : kOk;
}

}  // namespace ovws::cli
