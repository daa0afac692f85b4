#include "daemon/web/health.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/shared/client.hpp"
#include "proto/dark_image.hpp"
#include "proto/limits.hpp"
#include "proto/measurable_image.hpp"
#include "proto/slow_camera.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

constexpr double kSilentS = 3.0;  // status comes once per second
constexpr double kNoFramesS = 1.5;
constexpr double kRecentS = 10.0;
constexpr int kReferenceFrames = 100;
constexpr int kSlowStatuses = 3;
constexpr std::array<const char*, 4> kNames{"good", "note", "warning", "bad"};

std::string frames(std::int64_t count) {
  return fmt::format("{} frame{}", count, count == 1 ? "" : "s");
}

/// A button that leads to a panel of the page.
json lead(const char* label, const char* section) {
  return {{"label", label}, {"section", section}};
}

const json& to_events() {
  static const json action = lead("Show the events", "events");
  return action;
}

json call_of(const char* method, json params = json::object()) {
  return {{"method", method}, {"params", std::move(params)}};
}

/// A button that calls methods of the daemon, one after the other; it waits for jobs.
json act(const char* label, json calls) {
  return {{"label", label}, {"calls", std::move(calls)}};
}

json take_reference(const char* label) {
  return act(label, {call_of("reference.take", {{"frames", kReferenceFrames}})});
}

class Findings {
 public:
  void bad(std::string text, json action) { add(Wellness::bad, std::move(text), action); }
  void warning(std::string text, json action) { add(Wellness::warning, std::move(text), action); }
  void note(std::string text, json action) { add(Wellness::note, std::move(text), action); }
  std::vector<HealthFinding> sorted() {
    if (found_.empty()) add(Wellness::good, "The bench is OK", nullptr);
    std::stable_sort(found_.begin(), found_.end(),
                     [](const auto& a, const auto& b) { return a.wellness > b.wellness; });
    return std::move(found_);
  }

 private:
  void add(Wellness wellness, std::string text, json action) {
    found_.push_back({wellness, std::move(text), std::move(action)});
  }
  std::vector<HealthFinding> found_;
};

/// Whether the device works; if not, adds a finding with the reason.
bool check_device(const json& device, const char* title, const char* section, Findings& findings) {
  const json action = lead("Show its panel", section);
  if (device["fault"].is_string()) {
    findings.bad(fmt::format("{}: {}", title, device["fault"].get<std::string>()), action);
    return false;
  }
  if (device["connected"].get<bool>()) return true;
  findings.bad(fmt::format("{}: not connected; the daemon is trying to connect", title), action);
  return false;
}

void check_state(const json& status, Findings& findings) {
  const auto state = status.at("state").get<std::string>();
  if (state == "job_running") findings.note("A job is running", to_events());
  if (state == "starting") findings.note("The daemon is starting", to_events());
  if (state == "stopping") findings.bad("The daemon is stopping", to_events());
  if (state == "fault" && status.at("fault").is_string()) {
    findings.bad("Fault: " + status.at("fault").get<std::string>(), to_events());
  }
}

/// The daemon's next action against invalid frames, as text.
std::string action_of(const json& status) {
  const json invalid = status.at("sensor").value("invalid", json());
  if (!invalid.is_object()) return "";
  return "; " + invalid.at("action").get<std::string>();
}

/// Checks frames, reference, validity, saturation and lost spots; requires both devices to work.
void check_wavefront(const BenchFacts& facts, Findings& findings) {
  const json& wavefront = facts.wavefront;
  if (const std::string why = why_not_measurable(facts.status); !why.empty()) {
    findings.bad("No wavefront: " + why, lead("Show the image", "camera"));
    return;
  }
  if (wavefront.is_null() || facts.wavefront_age_s > kNoFramesS) {
    findings.bad("No frames arrive from the camera: check its cable and power, or run ovws doctor",
                 lead("Show the frame rate", "bench"));
    return;
  }
  const json& status = facts.status;
  const auto pattern = status.at("slm").at("pattern").get<std::string>();
  const bool referenced = status.at("sensor").at("referenced").get<bool>();
  if (pattern == "sensor" && !referenced) {
    const json unused = status.at("sensor").value("invalid", json());
    findings.warning(unused.is_object()
                         ? "No reference: " + unused.at("reason").get<std::string>()
                         : std::string("No reference: take one to measure coefficients"),
                     take_reference("Take a reference"));
  } else if (!wavefront.at("valid").get<bool>()) {
    const std::string why = cli::why_not_valid(wavefront, status);
    const bool passing = !wavefront.at("settled").get<bool>();
    if (pattern != "sensor") {
      findings.note(
          "No wavefront now: " + why,
          act("Show the sensor's hologram", {call_of("slm.show", {{"pattern", "sensor"}})}));
    } else if (passing) {
      findings.note("No wavefront now: " + why, to_events());
    } else {
      findings.bad("No wavefront: " + why + action_of(status), lead("Show the image", "camera"));
    }
  }
  const double saturated = wavefront.at("saturated").get<double>();
  if (saturated > 0.0) {
    const auto spots = std::lround(saturated * wavefront.at("subapertures").get<double>());
    const std::string text = fmt::format("{} of {} spots saturated: lower the exposure or the gain",
                                         spots, wavefront.at("subapertures").get<int>());
    const json action = act("Set the exposure", {call_of("camera.auto_exposure")});
    saturated > limits::kMaxSaturatedSpots ? findings.warning(text, action)
                                           : findings.note(text, action);
  }
  const int lost = wavefront.at("subapertures").get<int>() - wavefront.at("tracked").get<int>();
  if (pattern == "sensor" && lost > 0 && wavefront.at("valid").get<bool>()) {
    findings.warning(
        fmt::format("{} of {} spots lost", lost, wavefront.at("subapertures").get<int>()),
        lead("Show the image", "camera"));
  }
}

/// A dark image explains much of what the other checks find.
void check_light(const json& status, Findings& findings) {
  const json brightest = status.at("camera").value("brightest", json());
  if (!brightest.is_number() || !is_dark(brightest.get<double>())) return;
  findings.warning(fmt::format("The image is dark: its brightest pixels reach {:.1f} % of full "
                               "scale; {}",
                               100.0 * brightest.get<double>(), dark_advice("set the exposure")),
                   act("Set the exposure", {call_of("camera.auto_exposure")}));
}

/// Frames that are missing for some seconds: a single one does not change the head of the page.
void check_rate(const BenchFacts& facts, Findings& findings) {
  const auto slow = slow_camera(facts.status);
  if (!slow || facts.slow_statuses < kSlowStatuses) return;
  findings.warning(fmt::format("The camera sends {:.0f} of {} frames/s: {}", slow->measured_hz,
                               hz_text(slow->expected_hz), slow->advice("ovws doctor")),
                   lead("Show the frame rate", "bench"));
}

/// A reference that a new one should replace.
void check_reference(const json& status, Findings& findings) {
  const double introduced = status.at("sensor").value("reference_introduced_rms_waves", 0.0);
  if (introduced > 0.0) {
    findings.warning(
        fmt::format(
            "The reference contains an introduced aberration of {:.4f} wave RMS, and "
            "coefficients are relative to it: clear the aberration and take a new reference",
            introduced),
        act("Clear it and take a reference",
            {call_of("aberration.clear"),
             call_of("reference.take", {{"frames", kReferenceFrames}})}));
  }
  if (status.at("sensor").at("reference") == "stale") {
    findings.note(
        "The reference was taken with another gain, exposure or pixel format: take a new one",
        take_reference("Take a new one"));
  }
}

void check_counts(const BenchFacts& facts, Findings& findings) {
  const json layout = facts.status.at("sensor").value("layout_fault", json());
  if (layout.is_string()) {
    findings.warning(layout.get<std::string>(), lead("Show the image", "camera"));
  }
  if (facts.lost_lately > 0) {
    findings.warning(fmt::format("The camera lost {} in {} s", frames(facts.lost_lately), kRecentS),
                     lead("Show the history", "trends"));
  }
  if (facts.missed_lately > 0) {
    findings.warning(fmt::format("In the last {} s, {} took longer than a frame period from "
                                 "arrival to publication: lower the frame rate, or stop other "
                                 "programs on the daemon's machine",
                                 kRecentS, frames(facts.missed_lately)),
                     lead("Show the frame rate", "bench"));
  }
}

}  // namespace

std::vector<HealthFinding> examine_bench(const BenchFacts& facts) {
  Findings findings;
  if (facts.status.is_null() || facts.status_age_s > kSilentS) {
    findings.bad("The daemon is silent: check that ovwsd is running", to_events());
    return findings.sorted();
  }
  check_state(facts.status, findings);
  const bool camera = check_device(facts.status.at("camera"), "Camera", "camera", findings);
  const bool slm = check_device(facts.status.at("slm"), "SLM", "slm", findings);
  if (camera) check_light(facts.status, findings);
  if (camera) check_rate(facts, findings);
  if (camera && slm) check_wavefront(facts, findings);
  if (why_not_measurable(facts.status).empty()) check_reference(facts.status, findings);
  check_counts(facts, findings);
  return findings.sorted();
}

json findings_json(const std::vector<HealthFinding>& findings) {
  json list = json::array();
  for (const HealthFinding& finding : findings) {
    list.push_back({{"wellness", kNames[std::size_t(finding.wellness)]},
                    {"text", finding.text},
                    {"action", finding.action}});
  }
  return list;
}

void RiseLately::add(double t_s, std::int64_t count) {
  if (!samples_.empty() && count < samples_.back().count) samples_.clear();
  samples_.push_back({t_s, count});
  while (samples_.size() > 2 && t_s - samples_[1].t_s > kRecentS) samples_.pop_front();
}

std::int64_t RiseLately::rise() const {
  return samples_.empty() ? 0 : samples_.back().count - samples_.front().count;
}

}  // namespace ovws::web
