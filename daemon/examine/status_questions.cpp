#include "daemon/examine/status_questions.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/shared/client.hpp"
#include "daemon/shared/shell_word.hpp"
#include "proto/dark_image.hpp"
#include "proto/limits.hpp"
#include "proto/measurable_image.hpp"
#include "proto/slow_camera.hpp"

namespace ovws::examine {
namespace {

using nlohmann::json;

constexpr double kSilent_s = 3.0;  // status comes once per second
constexpr double kNoFrames_s = 1.5;
constexpr double kRecent_s = 10.0;
constexpr int kReferenceFrames = 100;
constexpr int kSlowStatuses = 3;
constexpr const char* kLog = "journalctl -u ovwsd -n 20";
constexpr const char* kExposure = "ovws exposure auto";
constexpr const char* kReference = "ovws reference 100";

/// A button that leads to a panel of the page.
json lead(const char* label, const char* section) {
  return {{"label", label}, {"section", section}};
}

json to_events() {
  return lead("Show the events", "events");
}

json to_image() {
  return lead("Show the image", "camera");
}

json to_rate() {
  return lead("Show the frame rate", "bench");
}

json call_of(const char* method, json params = json::object()) {
  return {{"method", method}, {"params", std::move(params)}};
}

/// A button that calls methods of the daemon, one after the other; it waits for jobs.
json act(const char* label, json calls) {
  return {{"label", label}, {"calls", std::move(calls)}};
}

json set_exposure() {
  return act("Set the exposure", {call_of("camera.auto_exposure")});
}

json take_reference() {
  return call_of("reference.take", {{"frames", kReferenceFrames}});
}

std::string frames(std::int64_t count) {
  return fmt::format("{} frame{}", count, count == 1 ? "" : "s");
}

bool has_fresh_frame(const DaemonFacts& facts) {
  return facts.wavefront.is_object() && facts.wavefront_age_s <= kNoFrames_s;
}

int lost_spots_of(const json& wavefront) {
  return wavefront.at("subapertures").get<int>() - wavefront.at("tracked").get<int>();
}

// The daemon --------------------------------------------------------------------------------------

bool is_silent(const DaemonFacts& facts) {
  return !facts.status || facts.status_age_s > kSilent_s;
}

Finding judge_answer(const DaemonFacts& facts) {
  if (facts.is_followed && is_silent(facts)) {
    return bad("the daemon is silent: check that ovwsd is running", "sudo systemctl start ovwsd",
               to_events());
  }
  if (facts.status) return good("a daemon answers at " + facts.endpoint);
  if (facts.refused) {
    return warning("the daemon at " + facts.endpoint + " refuses the request: " + facts.why,
                   "ovws --key FILE doctor");
  }
  return not_here(facts.why, std::string("sudo systemctl start ovwsd") +
                                 (facts.asks_for_keys ? " && ovws --key FILE doctor" : ""));
}

Finding judge_version(const DaemonFacts& facts) {
  const std::string version = text_at(*facts.status, "/versions/ovws");
  if (version == facts.own_version) {
    return good("the daemon has version " + version + ", the same as this program");
  }
  return warning(fmt::format("the daemon has version {}, this program {}: restart the daemon, or "
                             "remove the second installation",
                             version.empty() ? "unknown" : version, facts.own_version),
                 "sudo systemctl restart ovwsd");
}

Finding judge_state(const DaemonFacts& facts) {
  const std::string state = text_at(*facts.status, "/state");
  if (state == "job_running") return note("a job is running", "", to_events());
  if (state == "starting") return note("the daemon is starting", "", to_events());
  if (state == "stopping") return bad("the daemon is stopping", kLog, to_events());
  const std::string says = "the daemon is in state " + state;
  if (state == "fault") {
    const std::string why = text_at(*facts.status, "/fault");
    return bad(says + (why.empty() ? "" : ": " + why), kLog, to_events());
  }
  if (state.starts_with("waiting")) return not_here(says);  // the questions about devices say why
  return good(says);
}

Finding judge_store(const DaemonFacts& facts) {
  const std::string folder = text_at(*facts.status, "/store/directory");
  const std::string reason = text_at(*facts.status, "/store/reason");
  if (reason.empty()) return good("the daemon stores its measurements in " + folder);
  return warning((folder.empty() ? "the daemon saves nothing across restarts: "
                                 : "the daemon cannot store all its measurements: ") +
                     reason,
                 "\"state\": {\"directory\": \"/var/lib/ovws\"}");
}

Finding judge_job(const DaemonFacts& facts) {
  const std::string kind = text_at(*facts.status, "/failed_job/kind");
  if (kind.empty()) return good("no job has failed since its last success");
  return warning(fmt::format("job {} failed at {} and has not succeeded since: {}", kind,
                             text_at(*facts.status, "/failed_job/t_failed"),
                             text_at(*facts.status, "/failed_job/reason")),
                 "ovws call --wait " + shell_word(kind));
}

Finding judge_late(const DaemonFacts& facts) {
  if (facts.missed_lately == 0) return good("all frames are published in time");
  return warning(
      fmt::format("in the last {} s, {} took longer than a frame period from arrival to "
                  "publication: lower the frame rate, or stop other programs on the daemon's "
                  "machine",
                  kRecent_s, frames(facts.missed_lately)),
      "ovws doctor", to_rate());
}

// Camera and SLM ----------------------------------------------------------------------------------

/// Whether the daemon has opened the device; none: the status does not say it.
std::optional<bool> is_connected(const DaemonFacts& facts, const char* path) {
  const json::json_pointer pointer(path);
  if (!facts.status->contains(pointer) || !facts.status->at(pointer).is_boolean()) {
    return std::nullopt;
  }
  return facts.status->at(pointer).get<bool>();
}

Finding judge_device(const std::optional<bool>& connected, const std::string& fault,
                     const std::string& title, const char* section) {
  const json action = lead("Show its panel", section);
  if (!fault.empty()) return bad(title + ": " + fault, kLog, action);
  if (!connected) return not_here("the status does not say whether it is connected");
  if (*connected) return good(title + ": connected");
  return bad(title + ": not connected; the daemon is trying to connect", kLog, action);
}

Finding judge_camera(const DaemonFacts& facts) {
  return judge_device(is_connected(facts, "/camera/connected"),
                      text_at(*facts.status, "/camera/fault"), "camera", "camera");
}

Finding judge_slm(const DaemonFacts& facts) {
  return judge_device(is_connected(facts, "/slm/connected"), text_at(*facts.status, "/slm/fault"),
                      "SLM", "slm");
}

/// Too much light for some spots, however dark the others are.
Finding judge_saturation(const DaemonFacts& facts) {
  if (!has_fresh_frame(facts)) return not_here("no frames arrive");
  const double share = facts.wavefront.at("saturated").get<double>();
  const int spots = facts.wavefront.at("subapertures").get<int>();
  if (share == 0.0) return good("no spot is saturated");
  const std::string says =
      fmt::format("{} of {} spots are saturated; lower the exposure or the gain",
                  std::lround(share * spots), spots);
  return share > limits::kMaxSaturatedSpots ? warning(says, kExposure, set_exposure())
                                            : note(says, kExposure, set_exposure());
}

Finding judge_light(const DaemonFacts& facts) {
  const auto brightest = number_at(*facts.status, "/camera/brightest");
  if (!brightest)
    return not_here(
        "the daemon has seen no image in the last seconds (if stream.image_rate_hz is 0, it looks "
        "at none)");
  const std::string reach = fmt::format("reach {:.1f} % of full scale", 100.0 * *brightest);
  if (!is_dark(*brightest)) return good("the brightest pixels of the image " + reach);
  return warning(
      "the image is dark: its brightest pixels " + reach + "; " + dark_advice("set the exposure"),
      kExposure, set_exposure());
}

Finding judge_rate(const DaemonFacts& facts) {
  const double measured_hz = number_at(*facts.status, "/rates/grabbed_hz").value_or(0.0);
  if (measured_hz == 0.0) return not_here("the daemon has received no frame in the last second");
  const auto expected_hz = number_at(*facts.status, "/rates/expected_hz");
  if (!expected_hz) {
    return not_here(
        "no frame rate is expected now: the camera is triggered, a job is running, or the "
        "settings have just changed");
  }
  const std::string says = fmt::format("the camera sends {} of {} frames/s", hz_text(measured_hz),
                                       hz_text(*expected_hz));
  const auto slow = slow_camera(*facts.status);
  // A single status with too few frames does not change the head of the page.
  if (!slow || (facts.is_followed && facts.slow_statuses < kSlowStatuses)) return good(says);
  const std::string checks = facts.is_followed ? "ovws doctor" : "the checks camera.*";
  return warning(says + ": " + slow->advice(checks),
                 slow->is_slowed_by_exposure()
                     ? fmt::format("ovws exposure {:.0f}us", 0.5e6 / *expected_hz)
                     : "ovws rate " + hz_text(measured_hz),
                 to_rate());
}

Finding judge_losses(const DaemonFacts& facts) {
  if (facts.lost_lately == 0) return good("the camera has lost no frame");
  return warning(fmt::format("the camera lost {} in {} s", frames(facts.lost_lately), kRecent_s),
                 "ovws doctor", lead("Show the history", "trends"));
}

/// What the output shows, whichever program changed it.
Finding judge_levels(const DaemonFacts& facts) {
  if (!facts.levels) {
    return not_here(facts.why_no_levels.empty() ? "the daemon shows no hologram"
                                                : facts.why_no_levels);
  }
  const double differing = number_at(*facts.levels, "/differing_pixels").value_or(0.0);
  if (differing == 0.0) return good("the SLM's output shows the hologram exactly");
  const double pixels = number_at(*facts.status, "/slm/info/width").value_or(0.0) *
                        number_at(*facts.status, "/slm/info/height").value_or(0.0);
  const std::string says =
      fmt::format("{:.0f} pixels of the SLM's output differ from the hologram", differing);
  const char* const fix = "ovws call slm.verify";
  if (differing <= limits::kMaxDifferingPixels * pixels) {
    return warning(says + ": close what another program draws there (a window, a pointer)", fix);
  }
  return bad(says +
                 ": grey levels on the SLM are wrong; stop the compositor, or exclude the "
                 "window \"ovws SLM\" from its effects, then check again",
             fix);
}

// The sensor --------------------------------------------------------------------------------------

Finding judge_layout(const DaemonFacts& facts) {
  const std::string why = text_at(*facts.status, "/sensor/layout_fault");
  if (why.empty()) return good("the spots are expected in the camera's region");
  return bad("the sensor cannot measure with the settings that the daemon uses: " + why,
             "ovws setup spot", to_image());
}

/// Why the newest frame is not valid.
Finding judge_invalid(const DaemonFacts& facts) {
  const json& status = *facts.status;
  const std::string why = cli::why_not_valid(facts.wavefront, status);
  if (text_at(status, "/slm/pattern") != "sensor") {
    return note("no wavefront now: " + why, "ovws call slm.show pattern=sensor",
                act("Show the sensor's hologram", {call_of("slm.show", {{"pattern", "sensor"}})}));
  }
  if (facts.wavefront.at("settled") == false) {
    return note("no wavefront now: " + why, "", to_events());
  }
  const std::string next = text_at(status, "/sensor/invalid/action");
  return bad("no wavefront: " + why + (next.empty() ? "" : "; " + next), "ovws status", to_image());
}

bool needs_reference(const json& status) {
  return text_at(status, "/slm/pattern") == "sensor" &&
         status.at("sensor").at("referenced") == false;
}

Finding judge_frames(const DaemonFacts& facts) {
  const json& status = *facts.status;
  if (const std::string why = why_not_measurable(status); !why.empty()) {
    return bad("no wavefront: " + why, "ovws status", to_image());
  }
  if (!has_fresh_frame(facts)) {
    return bad("no frames arrive from the camera: check its cable and power, or run ovws doctor",
               "ovws doctor", to_rate());
  }
  if (needs_reference(status)) return not_here("there is no reference");
  if (facts.wavefront.at("valid") == false) return judge_invalid(facts);
  return good("the newest frame is valid");
}

Finding judge_spots(const DaemonFacts& facts) {
  if (!has_fresh_frame(facts) || text_at(*facts.status, "/slm/pattern") != "sensor" ||
      facts.wavefront.at("valid") == false) {
    return not_here("the newest frame is not valid");
  }
  const int lost = lost_spots_of(facts.wavefront);
  const int spots = facts.wavefront.at("subapertures").get<int>();
  if (lost == 0) return good("all spots are found");
  return warning(fmt::format("{} of {} spots lost", lost, spots), "ovws snapshot -o lost",
                 to_image());
}

Finding judge_reference(const DaemonFacts& facts) {
  const json& status = *facts.status;
  if (!why_not_measurable(status).empty()) return not_here("the image cannot be measured");
  if (needs_reference(status)) {
    const std::string unused = text_at(status, "/sensor/invalid/reason");
    return warning(
        "no reference: " + (unused.empty() ? "take one to measure coefficients" : unused),
        kReference, act("Take a reference", {take_reference()}));
  }
  return good("there is a reference");
}

Finding judge_stale(const DaemonFacts& facts) {
  if (!why_not_measurable(*facts.status).empty()) return not_here("the image cannot be measured");
  if (text_at(*facts.status, "/sensor/reference") != "stale")
    return good("the reference was taken with these camera settings");
  return note("the reference was taken with another gain, exposure or pixel format: take a new one",
              kReference, act("Take a new one", {take_reference()}));
}

Finding judge_introduced(const DaemonFacts& facts) {
  if (!why_not_measurable(*facts.status).empty()) return not_here("the image cannot be measured");
  const double introduced =
      number_at(*facts.status, "/sensor/reference_introduced_rms_waves").value_or(0.0);
  if (introduced > 0.0) {
    return warning(
        fmt::format("the reference contains an introduced aberration of {:.4f} wave RMS, and "
                    "coefficients are relative to it: clear the aberration and take a new "
                    "reference",
                    introduced),
        "ovws clear && ovws reference 100",
        act("Clear it and take a reference", {call_of("aberration.clear"), take_reference()}));
  }
  return good("the reference contains no introduced aberration");
}

constexpr unsigned kUsedCamera = kDaemon | kCamera;
constexpr unsigned kDevices = kDaemon | kCamera | kDisplay;
constexpr std::array<Question<DaemonFacts>, 19> kQuestions{{
    {"daemon.answer", judge_answer},
    {"daemon.version", judge_version, kDaemon, kDoctor},
    {"daemon.state", judge_state, kDaemon | kLater},
    {"daemon.store", judge_store, kDaemon, kDoctor},
    {"daemon.job", judge_job, kDaemon, kDoctor},
    {"daemon.late", judge_late, kDaemon, kPage},
    {"camera.state", judge_camera, kDaemon | kLater},
    {"camera.light", judge_light, kUsedCamera | kLater},
    {"camera.saturation", judge_saturation, kUsedCamera | kLater},
    {"camera.rate", judge_rate, kUsedCamera},
    {"camera.losses", judge_losses, kDaemon, kPage},
    {"slm.state", judge_slm, kDaemon | kLater},
    {"slm.levels", judge_levels, kDaemon, kDoctor},
    {"sensor.layout", judge_layout, kDaemon},
    {"sensor.frames", judge_frames, kDevices, kPage},
    {"sensor.spots", judge_spots, kDevices, kPage},
    {"sensor.reference", judge_reference, kDevices, kPage},
    {"sensor.stale", judge_stale, kDaemon, kPage},
    {"sensor.introduced", judge_introduced, kDaemon, kPage},
}};

std::string why_not(const DaemonFacts& facts, unsigned needs) {
  if ((needs & kDaemon) != 0 && is_silent(facts)) return "no daemon answers";
  const auto is_there = [&](Finding (*judge)(const DaemonFacts&)) {
    return judge(facts).severity != Severity::bad;
  };
  if ((needs & kCamera) != 0 && !is_there(judge_camera)) return "the camera is not in use";
  if ((needs & kDisplay) != 0 && !is_there(judge_slm)) return "the SLM is not in use";
  return {};
}

}  // namespace

Findings answers(const DaemonFacts& facts, Asker asker) {
  return answers<DaemonFacts>(kQuestions, facts, asker, why_not);
}

Findings page_findings(const DaemonFacts& facts) {
  Findings found = answers(facts, kPage);
  std::erase_if(found, [](const Finding& one) { return one.severity < Severity::note; });
  if (found.empty()) found.push_back(good("the bench is OK"));
  std::ranges::stable_sort(found, std::ranges::greater(), &Finding::severity);
  for (Finding& one : found) one.text.front() = char(std::toupper(one.text.front()));
  return found;
}

bool shows_holograms(const DaemonFacts& facts) {
  return facts.status && is_connected(facts, "/slm/connected") == true;
}

std::string why_not_verify(const DaemonFacts& facts) {
  const auto wait_for = [](const char* what, const char* then) {
    return fmt::format("not checked while {}, because read-back delays holograms: {}", what, then);
  };
  if (!facts.status) return "no daemon answers";
  if (text_at(*facts.status, "/state") == "job_running") {
    return wait_for("a job runs", "repeat ovws doctor after it");
  }
  const std::string loop = text_at(*facts.status, "/loop");
  if (loop == "closed" || loop == "paused") {
    return wait_for("the loop is closed", "open it (ovws loop open), then repeat ovws doctor");
  }
  return {};
}

std::string why_not_ready(const json& status) {
  const auto state = status.at("state").get<std::string>();
  if (state == "job_running") return "another job is running: wait for its end";
  if (state != "running") {
    return "the daemon is in state " + state + ", not running: ovws status says why";
  }
  if (status.at("slm").at("pattern") != "sensor") {
    return "the SLM does not show the sensor: ovws call slm.show pattern=sensor";
  }
  if (status.at("sensor").at("referenced").get<bool>()) return {};
  return "there is no reference: take one with a good wavefront first, ovws reference 100";
}

void RiseLately::add(double t_s, std::int64_t count) {
  if (!samples_.empty() && count < samples_.back().count) samples_.clear();
  samples_.push_back({t_s, count});
  while (samples_.size() > 2 && t_s - samples_[1].t_s > kRecent_s) samples_.pop_front();
}

std::int64_t RiseLately::rise() const {
  return samples_.empty() ? 0 : samples_.back().count - samples_.front().count;
}

}  // namespace ovws::examine
