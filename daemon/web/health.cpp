#include "daemon/web/health.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/shared/client.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

constexpr double kSilentS = 3.0;  // status comes once per second
constexpr double kNoFramesS = 1.5;
constexpr double kRecentS = 10.0;
constexpr double kMaxSaturated = 0.1;  // fraction of the spots; reference.take refuses more
constexpr std::array<const char*, 4> kNames{"good", "note", "warning", "bad"};

class Findings {
 public:
  void bad(std::string text) { add(Wellness::bad, std::move(text)); }
  void warning(std::string text) { add(Wellness::warning, std::move(text)); }
  void note(std::string text) { add(Wellness::note, std::move(text)); }
  std::vector<HealthFinding> sorted() {
    if (found_.empty()) add(Wellness::good, "The bench is OK");
    std::stable_sort(found_.begin(), found_.end(),
                     [](const auto& a, const auto& b) { return a.wellness > b.wellness; });
    return std::move(found_);
  }

 private:
  void add(Wellness wellness, std::string text) { found_.push_back({wellness, std::move(text)}); }
  std::vector<HealthFinding> found_;
};

/// Whether the device works; if not, adds a finding with the reason.
bool check_device(const json& device, const char* title, Findings& findings) {
  if (device["fault"].is_string()) {
    findings.bad(fmt::format("{}: {}", title, device["fault"].get<std::string>()));
    return false;
  }
  if (device["connected"].get<bool>()) return true;
  findings.bad(fmt::format("{}: not connected; the daemon is trying to connect", title));
  return false;
}

void check_state(const json& status, Findings& findings) {
  const auto state = status.at("state").get<std::string>();
  if (state == "job_running") findings.note("A job is running");
  if (state == "starting") findings.note("The daemon is starting");
  if (state == "stopping") findings.bad("The daemon is stopping");
  if (state == "fault" && status.at("fault").is_string()) {
    findings.bad("Fault: " + status.at("fault").get<std::string>());
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
  if (wavefront.is_null() || facts.wavefront_age_s > kNoFramesS) {
    findings.bad("No frames arrive from the camera: check its cable and power, or run ovws doctor");
    return;
  }
  const json& status = facts.status;
  const auto pattern = status.at("slm").at("pattern").get<std::string>();
  const bool referenced = status.at("sensor").at("referenced").get<bool>();
  if (pattern == "sensor" && !referenced) {
    findings.warning("No reference: take one to measure coefficients");
  } else if (!wavefront.at("valid").get<bool>()) {
    const std::string why = cli::why_not_valid(wavefront, status);
    const bool passing = !wavefront.at("settled").get<bool>();
    passing || pattern != "sensor" ? findings.note("No wavefront now: " + why)
                                   : findings.bad("No wavefront: " + why + action_of(status));
  }
  const double saturated = wavefront.at("saturated").get<double>();
  if (saturated > 0.0) {
    const auto spots = std::lround(saturated * wavefront.at("subapertures").get<double>());
    const std::string text = fmt::format("{} of {} spots saturated: lower the exposure or the gain",
                                         spots, wavefront.at("subapertures").get<int>());
    saturated > kMaxSaturated ? findings.warning(text) : findings.note(text);
  }
  const int lost = wavefront.at("subapertures").get<int>() - wavefront.at("tracked").get<int>();
  if (pattern == "sensor" && lost > 0 && wavefront.at("valid").get<bool>()) {
    findings.warning(
        fmt::format("{} of {} spots lost", lost, wavefront.at("subapertures").get<int>()));
  }
}

void check_counts(const BenchFacts& facts, Findings& findings) {
  const double introduced = facts.status.at("sensor").value("reference_introduced_rms_waves", 0.0);
  if (introduced > 0.0) {
    findings.warning(fmt::format(
        "The reference contains an introduced aberration of {:.4f} wave RMS, and "
        "coefficients are relative to it: clear the aberration and take a new reference",
        introduced));
  }
  if (facts.status.at("sensor").at("reference") == "stale") {
    findings.note(
        "The reference was taken with another gain, exposure or pixel format: take a new one");
  }
  if (facts.lost_lately > 0) {
    findings.warning(fmt::format("The camera lost {} frames in {} s", facts.lost_lately, kRecentS));
  }
  if (facts.missed_lately > 0) {
    findings.warning(
        fmt::format("{} frames of the last {} s were published more than a frame "
                    "period after they arrived: lower the frame rate, or stop other "
                    "programs on the daemon's machine",
                    facts.missed_lately, kRecentS));
  }
}

}  // namespace

std::vector<HealthFinding> examine_bench(const BenchFacts& facts) {
  Findings findings;
  if (facts.status.is_null() || facts.status_age_s > kSilentS) {
    findings.bad("The daemon is silent: check that ovwsd is running");
    return findings.sorted();
  }
  check_state(facts.status, findings);
  const bool camera = check_device(facts.status.at("camera"), "Camera", findings);
  const bool slm = check_device(facts.status.at("slm"), "SLM", findings);
  if (camera && slm) check_wavefront(facts, findings);
  check_counts(facts, findings);
  return findings.sorted();
}

json findings_json(const std::vector<HealthFinding>& findings) {
  json list = json::array();
  for (const HealthFinding& finding : findings) {
    list.push_back({{"wellness", kNames[std::size_t(finding.wellness)]}, {"text", finding.text}});
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
