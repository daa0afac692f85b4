#include "daemon/examine/machine/daemon_answer.hpp"

#include <fmt/core.h>

#include <thread>

#include "proto/dark_image.hpp"
#include "proto/limits.hpp"
#include "proto/slow_camera.hpp"

namespace ovws::doctor {
namespace {

using nlohmann::json;

constexpr double kOpeningS = 5.0;
constexpr int kMostAsked = 12;  // a daemon that crashes starts again and again
constexpr const char* kNoAnswer = "no daemon answers";
constexpr const char* kLog = "journalctl -u ovwsd -n 20";

/// String at this JSON pointer of the status; empty if there is no string.
std::string text_at(const json& status, const char* path) {
  const json::json_pointer pointer(path);
  if (!status.contains(pointer) || !status.at(pointer).is_string()) return {};
  return status.at(pointer).get<std::string>();
}

Finding judge_answer(const DaemonFacts& facts) {
  if (facts.status) return ok("a daemon answers at " + facts.endpoint);
  if (facts.refused) {
    return warning("the daemon at " + facts.endpoint + " refuses the request: " + facts.why,
                   "ovws --key FILE doctor");
  }
  return not_here(facts.why, std::string("sudo systemctl start ovwsd") +
                                 (facts.asks_for_keys ? " && ovws --key FILE doctor" : ""));
}

Finding judge_version(const DaemonFacts& facts) {
  if (!facts.status) return not_here(kNoAnswer);
  const std::string version = text_at(*facts.status, "/versions/ovws");
  if (version == facts.own_version)
    return ok("the daemon has version " + version + ", the same as this program");
  return warning(fmt::format("the daemon has version {}, this program {}: restart the daemon, or "
                             "remove the second installation",
                             version.empty() ? "unknown" : version, facts.own_version),
                 "sudo systemctl restart ovwsd");
}

Finding judge_state(const DaemonFacts& facts) {
  if (!facts.status) return not_here(kNoAnswer);
  const std::string state = text_at(*facts.status, "/state");
  for (const char* part : {"camera", "slm"}) {
    const std::string fault_text = text_at(*facts.status, fmt::format("/{}/fault", part).c_str());
    if (!fault_text.empty()) {
      return fault(
          fmt::format("the daemon is in state {}; its {} reports: {}", state, part, fault_text),
          kLog);
    }
  }
  if (state == "fault" || state.starts_with("waiting")) {
    return fault("the daemon is in state " + state, kLog);
  }
  return ok("the daemon is in state " + state);
}

Finding judge_store(const DaemonFacts& facts) {
  if (!facts.status) return not_here(kNoAnswer);
  const std::string reason = text_at(*facts.status, "/store/reason");
  if (reason.empty()) {
    return ok("the daemon stores its measurements in " +
              text_at(*facts.status, "/store/directory"));
  }
  return warning("the daemon cannot store all its measurements: " + reason,
                 "\"state\": {\"directory\": \"/var/lib/ovws\"}");
}

Finding judge_job(const DaemonFacts& facts) {
  if (!facts.status) return not_here(kNoAnswer);
  const std::string kind = text_at(*facts.status, "/failed_job/kind");
  if (kind.empty()) return ok("no job has failed since its last success");
  return warning(fmt::format("job {} failed at {} and has not succeeded since: {}", kind,
                             text_at(*facts.status, "/failed_job/t_failed"),
                             text_at(*facts.status, "/failed_job/reason")),
                 "ovws call --wait " + kind);
}

Finding judge_light(const DaemonFacts& facts) {
  if (!facts.status) return not_here(kNoAnswer);
  const json::json_pointer pointer("/camera/brightest");
  if (!facts.status->contains(pointer) || !facts.status->at(pointer).is_number()) {
    return not_here("the daemon has seen no image in the last seconds");
  }
  const double brightest = facts.status->at(pointer).get<double>();
  const std::string says = fmt::format(
      "the brightest pixels of the image reach {:.1f} % of full scale", 100.0 * brightest);
  if (facts.saturated.value_or(0.0) > limits::kMaxSaturatedSpots) {
    return warning(fmt::format("the image is too bright: {:.0f} % of the spots are saturated; "
                               "lower the exposure or the gain",
                               100.0 * *facts.saturated),
                   "ovws exposure auto");
  }
  if (!is_dark(brightest)) return ok(says);
  return warning("the image is dark: " + says + "; " + dark_advice("set the exposure"),
                 "ovws exposure auto");
}

Finding judge_rate(const DaemonFacts& facts) {
  if (!facts.status) return not_here(kNoAnswer);
  const double measured_hz = number_at(*facts.status, "/rates/grabbed_hz").value_or(0.0);
  if (measured_hz == 0.0) return not_here("the daemon has received no frame in the last second");
  const auto expected_hz = number_at(*facts.status, "/rates/expected_hz");
  if (!expected_hz) {
    return not_here(
        "no frame rate is expected now: the camera is triggered, a job is running, or the "
        "settings have just changed");
  }
  const std::string says = fmt::format("the camera sends {} frames/s and is set to {}",
                                       hz_text(measured_hz), hz_text(*expected_hz));
  const auto slow = slow_camera(*facts.status);
  if (!slow) return ok(says);
  return warning(says + ": " + slow->advice("the checks camera.*"),
                 slow->is_slowed_by_exposure()
                     ? fmt::format("ovws exposure {:.0f}us", 0.5e6 / *expected_hz)
                     : "ovws rate " + hz_text(measured_hz));
}

/// What the output shows, whichever program changed it.
Finding judge_levels(const DaemonFacts& facts) {
  if (!facts.status) return not_here(kNoAnswer);
  if (!facts.levels) {
    return not_here(facts.why_no_levels.empty() ? "the daemon shows no hologram"
                                                : facts.why_no_levels);
  }
  const double differing = number_at(*facts.levels, "/differing_pixels").value_or(0.0);
  if (differing == 0.0) return ok("the SLM's output shows the hologram exactly");
  const double pixels = number_at(*facts.status, "/slm/info/width").value_or(0.0) *
                        number_at(*facts.status, "/slm/info/height").value_or(0.0);
  const std::string says =
      fmt::format("{:.0f} pixels of the SLM's output differ from the hologram", differing);
  const char* const fix = "ovws call slm.verify";
  if (differing <= limits::kMaxDifferingPixels * pixels) {
    return warning(says + ": close what another program draws there (a window, a pointer)", fix);
  }
  return fault(says +
                   ": grey levels on the SLM are wrong; stop the compositor, or exclude the "
                   "window \"ovws SLM\" from its effects, then check again",
               fix);
}

/// Whether this is the answer of a daemon that may still be opening its devices.
bool is_opening(const DaemonFacts& facts) {
  const json::json_pointer uptime("/uptime_s");
  if (!facts.status || !facts.status->contains(uptime) || !facts.status->at(uptime).is_number()) {
    return false;
  }
  const std::string state = text_at(*facts.status, "/state");
  const bool waits = state == "starting" || state.starts_with("waiting") ||
                     (state == "fault" && camera_of(facts) == DaemonsCamera::without);
  return waits && facts.status->at(uptime).get<double>() < kOpeningS;
}

}  // namespace

DaemonFacts ask_opened(const AskDaemon& ask, const std::string& endpoint,
                       std::chrono::milliseconds pause) {
  DaemonFacts facts = ask(endpoint);
  for (int asked = 1; is_opening(facts) && asked < kMostAsked; ++asked) {
    std::this_thread::sleep_for(pause);
    facts = ask(endpoint);
  }
  return facts;
}

DaemonsCamera camera_of(const DaemonFacts& facts) {
  if (!facts.status) return DaemonsCamera::silent;
  const json::json_pointer info("/camera/info");
  const bool has = facts.status->contains(info) && facts.status->at(info).is_object();
  return has ? DaemonsCamera::with : DaemonsCamera::without;
}

bool shows_holograms(const DaemonFacts& facts) {
  const json::json_pointer connected("/slm/connected");
  return facts.status && facts.status->contains(connected) && facts.status->at(connected) == true;
}

std::string why_not_verify(const DaemonFacts& facts) {
  const auto wait_for = [](const char* what, const char* then) {
    return fmt::format("not checked while {}, because read-back delays holograms: {}", what, then);
  };
  if (!facts.status) return kNoAnswer;
  if (text_at(*facts.status, "/state") == "job_running") {
    return wait_for("a job runs", "repeat ovws doctor after it");
  }
  const std::string loop = text_at(*facts.status, "/loop");
  if (loop == "closed" || loop == "paused") {
    return wait_for("the loop is closed", "open it (ovws loop open), then repeat ovws doctor");
  }
  return {};
}

std::optional<std::string> state_folder_of(const DaemonFacts& facts) {
  const std::string folder = facts.status ? text_at(*facts.status, "/store/directory") : "";
  return folder.empty() ? std::nullopt : std::optional(folder);
}

std::string store_fault_of(const DaemonFacts& facts) {
  return facts.status ? text_at(*facts.status, "/store/reason") : "";
}

std::string layout_fault_of(const DaemonFacts& facts) {
  return facts.status ? text_at(*facts.status, "/sensor/layout_fault") : "";
}

Findings judge(const DaemonFacts& facts) {
  return run_checks<DaemonFacts>({{"daemon.answer", judge_answer},
                                  {"daemon.version", judge_version},
                                  {"daemon.state", judge_state},
                                  {"daemon.store", judge_store},
                                  {"daemon.job", judge_job},
                                  {"camera.light", judge_light},
                                  {"camera.rate", judge_rate},
                                  {"slm.levels", judge_levels}},
                                 facts);
}

}  // namespace ovws::doctor
