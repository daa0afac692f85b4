#include "daemon/ovws/text/status.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/base/number_text.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/losses.hpp"
#include "daemon/ovws/text/quantity.hpp"
#include "proto/dark_image.hpp"
#include "proto/limits.hpp"
#include "proto/slow_camera.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

std::string text_of(const json& object, const char* key) {
  return object.at(key).is_string() ? object.at(key).get<std::string>() : "";
}

std::string line(const char* subject, const std::string& text) {
  return text.empty() ? "" : fmt::format("{:<10} {}\n", subject, text);
}

std::string state_text(const json& status) {
  std::string text = fmt::format("{}; the daemon started {} ago", text_of(status, "state"),
                                 time_text(std::round(status.at("uptime_s").get<double>())));
  const std::string fault = text_of(status, "fault");
  return fault.empty() ? text : text + "; " + fault;
}

/// How bright the newest image is, and what to do if it is dark.
std::string brightness_text(const json& brightest) {
  if (!brightest.is_number()) return "";
  const double fraction = brightest.get<double>();
  const std::string text =
      fmt::format("brightest pixels at {:.1f} % of full scale", 100.0 * fraction);
  return is_dark(fraction) ? text + ": DARK; " + dark_advice("ovws exposure auto") : text;
}

std::string camera_lines(const json& status) {
  const json& camera = status.at("camera");
  std::string lines;
  if (camera.at("info").is_object()) {
    const json& info = camera.at("info");
    lines += line("camera",
                  fmt::format("{} {} at {}, {}", text_of(info, "vendor"), text_of(info, "model"),
                              text_of(info, "address"), measured_rate_text(status)));
  }
  lines += line("camera", text_of(camera, "fault"));
  lines += line("image", brightness_text(camera.value("brightest", json())));
  const json& settings = camera.at("settings");
  return settings.is_object() ? lines + line("settings", camera_settings_text(settings)) : lines;
}

std::string slm_lines(const json& slm) {
  std::string lines;
  if (slm.at("info").is_object()) {
    const json& info = slm.at("info");
    if (info.at("output") == "none") return line("slm", "none: a fixed array of lenslets");
    lines += line("slm",
                  fmt::format("{} {}x{}, {} shown, hologram {}", text_of(info, "output"),
                              info.at("width").get<int>(), info.at("height").get<int>(),
                              text_of(slm, "pattern"), slm.at("hologram_id").get<std::uint64_t>()));
  }
  return lines + line("slm", text_of(slm, "fault"));
}

std::string sensor_lines(const json& sensor) {
  std::string lines = line(
      "sensor", fmt::format("charge {}, {} subapertures, {} modes, tracker {}",
                            sensor.at("charge").get<int>(), sensor.at("subapertures").get<int>(),
                            sensor.at("modes").get<int>(), text_of(sensor, "tracker")));
  for (const char* key : {"layout_fault", "operator_reason"}) {
    const std::string fault = text_of(sensor, key);
    if (!fault.empty()) lines += line("sensor", fmt::format("{}: {}", key, fault));
  }
  const json& invalid = sensor.at("invalid");
  if (!invalid.is_object()) return lines;
  return lines + line("sensor", fmt::format("invalid: {}; {}", text_of(invalid, "reason"),
                                            text_of(invalid, "action")));
}

/// One line for each further light source.
std::string beam_lines(const BenchState& bench) {
  const bool is_measured = bench.wavefront.is_object() && bench.wavefront.at("settled");
  std::string lines;
  for (const json& beam : bench.status.at("sensor").value("beams", json::array())) {
    const json& offset = beam.at("offset_px");
    const std::string reason = text_of(beam, "reason");
    lines += line("beam", fmt::format("{} at ({:+.1f}, {:+.1f}) px: {}", text_of(beam, "name"),
                                      offset.at(0).get<double>(), offset.at(1).get<double>(),
                                      beam.at("referenced") == false ? "no reference"
                                      : !reason.empty()              ? "NOT VALID: " + reason
                                      : is_measured                  ? "valid"
                                                                     : "not measured now"));
  }
  return lines;
}

std::string reference_lines(const json& sensor, const json& reference) {
  std::string lines = line("reference", reference_text(reference));
  const double introduced = sensor.at("reference_introduced_rms_waves").get<double>();
  if (introduced == 0.0) return lines;
  return lines +
         line("reference",
              fmt::format("contains an introduced aberration of {:.4f} wave RMS, and coefficients "
                          "are relative to it; for one without: ovws clear, then ovws reference "
                          "100",
                          introduced));
}

std::string spots_text(const json& frame) {
  const double saturated = frame.at("saturated").get<double>();
  const std::string text =
      fmt::format("{} of {} spots, {:.0f} % saturated", frame.at("tracked").get<int>(),
                  frame.at("subapertures").get<int>(), 100.0 * saturated);
  if (!(saturated > limits::kMaxSaturatedSpots)) return text;
  return text + ": TOO BRIGHT; ovws exposure auto, or a lower gain";
}

std::string wavefront_text(const BenchState& bench) {
  const json& frame = bench.wavefront;
  if (!frame.is_object()) return "no frame is published";
  const std::string spots = spots_text(frame);
  if (!frame.at("valid").get<bool>()) return "NOT VALID: " + bench.not_valid + "; " + spots;
  return fmt::format("RMS {:.4f} wave without tilts, {}", frame.at("rms_waves").get<double>(),
                     spots);
}

std::string failed_text(const json& failed) {
  if (!failed.is_object()) return "";
  const std::string field = text_of(failed, "field");
  return fmt::format("job {} ({}) at {}: {}{}", failed.at("job").get<int>(),
                     text_of(failed, "kind"), text_of(failed, "t_failed"),
                     field.empty() ? "" : field + ": ", text_of(failed, "reason"));
}

std::string refine_text(const json& refine) {
  const std::string state = text_of(refine, "state"), reason = text_of(refine, "reason");
  if (state == "off") return "";
  return reason.empty() ? state : state + ": " + reason;
}

std::string latency_text(const json& latency) {
  if (!latency.contains("published")) return "";
  const json& published = latency.at("published");
  if (published.at("count").get<std::uint64_t>() == 0) return "";
  return fmt::format("{} from a frame's arrival to its message (median), {} for 99 %",
                     time_text(1e-6 * published.at("p50_us").get<double>()),
                     time_text(1e-6 * published.at("p99_us").get<double>()));
}

std::string losses_text(const json& counters) {
  std::string text;
  for (const std::string_view name : kLosses) {
    const auto count = counters.value(std::string(name), std::uint64_t(0));
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
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
    text += fmt::format(", {} {}", text_of(mode, "name"),
                        signed_decimals(mode.at("waves").get<double>(), 4));
  }
  if (shown.size() < modes.size()) text += ", …";
  return loop.at("closed") == true ? text : text + "; remove it with: ovws loop clear";
}

std::string status_text(const BenchState& bench) {
  const json& status = bench.status;
  const json& sensor = status.at("sensor");
  const std::size_t patterns = bench.aberration.value("patterns", json::array()).size();
  const std::string introduced = patterns > 0 ? fmt::format("a sequence of {} patterns", patterns)
                                              : modes_text(bench.aberration.at("modes"));
  return line("state", state_text(status)) + camera_lines(status) + slm_lines(status.at("slm")) +
         sensor_lines(sensor) + reference_lines(sensor, bench.reference) +
         line("wavefront", wavefront_text(bench)) + beam_lines(bench) +
         line("aberration", introduced.empty() ? "none" : introduced + " introduced") +
         line("correction", correction_text(bench.correction.at("modes"), bench.loop)) +
         line("loop", loop_text(bench.loop)) + line("recording", record_text(status.at("record"))) +
         line("failed", failed_text(status.at("failed_job"))) +
         line("store", text_of(status.at("store"), "reason")) +
         line("refine", refine_text(status.at("refine"))) +
         line("latency", latency_text(status.at("latency"))) +
         line("losses", losses_text(status.at("counters")));
}

}  // namespace ovws::cli
