#include "daemon/ovws/doctor/daemon_answer.hpp"

#include <fmt/core.h>

namespace ovws::doctor {
namespace {

using nlohmann::json;

constexpr const char* kLog = "journalctl -u ovwsd -n 20";

/// The string at this JSON pointer; empty if it is missing or not a string.
std::string text_at(const json& status, const char* path) {
  const json::json_pointer pointer(path);
  if (!status.contains(pointer) || !status.at(pointer).is_string()) return {};
  return status.at(pointer).get<std::string>();
}

Finding judge_answer(const DaemonFacts& facts) {
  constexpr const char* kName = "daemon.answer";
  if (facts.status) return ok(kName, "a daemon answers at " + facts.endpoint);
  if (facts.refused) {
    return warning(kName, "the daemon at " + facts.endpoint + " refuses the request: " + facts.why,
                   "ovws --key FILE doctor");
  }
  return not_here(kName, facts.why,
                  std::string("sudo systemctl start ovwsd") +
                      (facts.asks_for_keys ? " && ovws --key FILE doctor" : ""));
}

Finding judge_version(const DaemonFacts& facts) {
  constexpr const char* kName = "daemon.version";
  const std::string version = text_at(*facts.status, "/versions/ovws");
  if (version == facts.own_version)
    return ok(kName, "the daemon has version " + version + ", the same as this program");
  return warning(kName,
                 fmt::format("the daemon has version {}, this program {}: restart the daemon, or "
                             "remove the second installation",
                             version.empty() ? "unknown" : version, facts.own_version),
                 "sudo systemctl restart ovwsd");
}

Finding judge_state(const DaemonFacts& facts) {
  constexpr const char* kName = "daemon.state";
  const std::string state = text_at(*facts.status, "/state");
  for (const char* part : {"camera", "slm"}) {
    const std::string fault_text = text_at(*facts.status, fmt::format("/{}/fault", part).c_str());
    if (!fault_text.empty()) {
      return fault(
          kName,
          fmt::format("the daemon is in state {}; its {} reports: {}", state, part, fault_text),
          kLog);
    }
  }
  if (state == "fault" || state.starts_with("waiting")) {
    return fault(kName, "the daemon is in state " + state, kLog);
  }
  return ok(kName, "the daemon is in state " + state);
}

Finding judge_store(const DaemonFacts& facts) {
  constexpr const char* kName = "daemon.store";
  const std::string reason = text_at(*facts.status, "/store/reason");
  if (reason.empty()) {
    return ok(kName, "the daemon stores its measurements in " +
                         text_at(*facts.status, "/store/directory"));
  }
  return warning(kName, "the daemon cannot store all its measurements: " + reason,
                 "\"state\": {\"directory\": \"/var/lib/ovws\"}");
}

Finding judge_job(const DaemonFacts& facts) {
  constexpr const char* kName = "daemon.job";
  const std::string kind = text_at(*facts.status, "/failed_job/kind");
  if (kind.empty()) return ok(kName, "no job has failed since its last success");
  return warning(kName,
                 fmt::format("job {} failed at {} and has not succeeded since: {}", kind,
                             text_at(*facts.status, "/failed_job/t_failed"),
                             text_at(*facts.status, "/failed_job/reason")),
                 "ovws call --wait " + kind);
}

}  // namespace

DaemonsCamera camera_of(const DaemonFacts& facts) {
  if (!facts.status) return DaemonsCamera::silent;
  const json::json_pointer info("/camera/info");
  const bool has = facts.status->contains(info) && facts.status->at(info).is_object();
  return has ? DaemonsCamera::with : DaemonsCamera::without;
}

Findings judge(const DaemonFacts& facts) {
  Findings found{judge_answer(facts)};
  if (facts.status) {
    for (const auto& check : {judge_version, judge_state, judge_store, judge_job}) {
      found.push_back(check(facts));
    }
    return found;
  }
  for (const char* name : {"daemon.version", "daemon.state", "daemon.store", "daemon.job"}) {
    found.push_back(not_here(name, "no daemon answers"));
  }
  return found;
}

}  // namespace ovws::doctor
