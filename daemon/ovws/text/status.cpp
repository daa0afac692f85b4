#include "daemon/ovws/text/status.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <vector>

#include "core/rt/counters.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "proto/dark_image.hpp"
#include "proto/limits.hpp"
#include "proto/slow_camera.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

/// A line of the status: its subject, and a template for system.status with what status_text adds.
/// Without text there is no line.
struct Line {
  const char *subject, *form;
};
constexpr Line kLines[]{
    {"state", "{state}; the daemon started {uptime_s:time} ago[fault?; {fault}]"},
    {"camera",
     "[camera.info?{camera.info.vendor} {camera.info.model} at {camera.info.address}, {rate}]"},
    {"camera", "[camera.fault?{camera.fault}]"},
    {"image", "{brightness}"},
    {"settings", "[camera.settings?{camera.settings:camera}]"},
    {"slm",
     "[slm.info?[slm.info.output=none?none: a fixed array of lenslets]"
     "[!slm.info.output=none?{slm.info.output} {slm.info.width}x{slm.info.height}, {slm.pattern} "
     "shown, hologram {slm.hologram_id}]]"},
    {"slm", "[slm.fault?{slm.fault}]"},
    {"sensor",
     "charge {sensor.charge}, {sensor.subapertures} subapertures, {sensor.modes} modes, tracker "
     "{sensor.tracker}"},
    {"sensor", "[sensor.layout_fault?layout_fault: {sensor.layout_fault}]"},
    {"sensor", "[sensor.operator_reason?operator_reason: {sensor.operator_reason}]"},
    {"sensor", "[sensor.invalid?invalid: {sensor.invalid.reason}; {sensor.invalid.action}]"},
    {"reference", "{reference}"},
    {"reference",
     "[sensor.reference_introduced_rms_waves?contains an introduced aberration of "
     "{sensor.reference_introduced_rms_waves:.4f} wave RMS, and coefficients are relative to it; "
     "for one without: ovws clear, then ovws reference 100]"},
    {"wavefront", "{wavefront}"},
    {"beam",
     "[sensor.beams*{name} at ({offset_px.0:+.1f}, {offset_px.1:+.1f}) px: "
     "[!referenced?no reference][referenced?[reason?NOT VALID: {reason}]"
     "[!reason?[is_measured?valid][!is_measured?not measured now]]]\n]"},
    {"aberration",
     "[patterns?a sequence of {patterns} patterns introduced]"
     "[!patterns?[introduced?{introduced} introduced][!introduced?none]]"},
    {"correction", "{correction}"},
    {"loop", "{loop}"},
    {"recording", "{recording}"},
    {"failed",
     "[failed_job?job {failed_job.job} ({failed_job.kind}) at {failed_job.t_failed}: "
     "[failed_job.field?{failed_job.field}: ]{failed_job.reason}]"},
    {"store", "[store.reason?{store.reason}]"},
    {"refine", "[!refine.state=off?{refine.state}[refine.reason?: {refine.reason}]]"},
    {"latency",
     "[latency.published.count?{published_s.p50:time} from a frame's arrival to its message "
     "(median), {published_s.p99:time} for 99 %]"},
    {"losses", "{losses}"}};

/// How bright the newest image is, and what to do if it is dark.
std::string brightness_text(const json& brightest) {
  if (!brightest.is_number()) return "";
  const double fraction = brightest.get<double>();
  const std::string text =
      fmt::format("brightest pixels at {:.1f} % of full scale", 100.0 * fraction);
  return is_dark(fraction) ? text + ": DARK; " + dark_advice("ovws exposure auto") : text;
}

std::string spots_text(const json& frame) {
  json said = frame;
  said["too_bright"] = frame.at("saturated").get<double>() > limits::kMaxSaturatedSpots;
  return fill(
      "{tracked} of {subapertures} spots, {saturated*100:.0f} % saturated"
      "[too_bright?: TOO BRIGHT; ovws exposure auto, or a lower gain]",
      said);
}

std::string wavefront_text(const BenchState& bench) {
  const json& frame = bench.wavefront;
  if (!frame.is_object()) return "no frame is published";
  const std::string spots = spots_text(frame);
  if (!frame.at("valid").get<bool>()) return "NOT VALID: " + bench.not_valid + "; " + spots;
  return fill("RMS {rms_waves:.4f} wave without tilts, ", frame) + spots;
}

std::string losses_text(const json& counters) {
  std::string text;
  for (const auto& [name, help, is_loss] : all_counters()) {
    const auto count = counters.value(std::string(name), std::uint64_t(0));
    if (is_loss && count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
  }
  return text.empty() ? "none since the start" : text + " since the start";
}

}  // namespace

std::string measured_rate_text(const json& status) {
  const std::string text =
      fmt::format("{:.1f} frames/s", status.at("rates").at("grabbed_hz").get<double>());
  const auto slow = slow_camera(status);
  if (!slow) return text;
  return fmt::format("{} of {}: SLOW; {}", text, hz_text(slow->expected_hz),
                     slow->advice("ovws doctor"));
}

std::string correction_text(const json& modes, const json& loop) {
  constexpr double kLeastWaves = 0.0005;
  constexpr std::size_t kMostModes = 6;
  const auto size = [](const json& mode) { return std::abs(mode.at("waves").get<double>()); };
  double square = 0.0;
  std::vector<json> shown;
  for (const json& mode : modes) {
    square += size(mode) * size(mode);
    if (size(mode) >= kLeastWaves) shown.push_back(mode);
  }
  if (square == 0.0) return "";
  std::ranges::stable_sort(shown, std::ranges::greater(), size);
  shown.resize(std::min(shown.size(), kMostModes));
  std::string text = fmt::format("{:.4f} wave RMS", std::sqrt(square));
  for (const json& mode : shown) {
    text += fill(", {name} {waves:signed}", mode);
  }
  if (shown.size() < modes.size()) text += ", …";
  return loop.at("closed") == true ? text : text + "; remove it with: ovws loop clear";
}

std::string status_text(const BenchState& bench) {
  json said = bench.status;
  said["uptime_s"] = std::round(said.at("uptime_s").get<double>());
  said["rate"] = measured_rate_text(bench.status);
  said["brightness"] = brightness_text(said.at("camera").value("brightest", json()));
  said["reference"] = reference_text(bench.reference);
  said["wavefront"] = wavefront_text(bench);
  for (json& beam : said.at("sensor")["beams"]) {
    beam["is_measured"] = bench.wavefront.is_object() && bench.wavefront.at("settled");
  }
  said["patterns"] = bench.aberration.value("patterns", json::array()).size();
  said["introduced"] = modes_text(bench.aberration.at("modes"));
  said["correction"] = correction_text(bench.correction.at("modes"), bench.loop);
  said["loop"] = loop_text(bench.loop);
  said["recording"] = record_text(said.at("record"));
  if (const json published = said.at("latency").value("published", json()); published.is_object()) {
    for (const char* share : {"p50", "p99"}) {
      said["published_s"][share] = 1e-6 * published.at(share + std::string("_us")).get<double>();
    }
  }
  said["losses"] = losses_text(said.at("counters"));
  std::string text;
  for (const Line& line : kLines) {
    std::istringstream all(fill(line.form, said));
    for (std::string one; std::getline(all, one);) {
      text += fmt::format("{:<10} {}\n", line.subject, one);
    }
  }
  return text;
}

}  // namespace ovws::cli
