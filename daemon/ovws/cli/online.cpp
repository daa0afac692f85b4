/// ovws status and describe: what a daemon is and does.
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/shared/client.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

std::string text_or(const json& object, const char* key, const std::string& otherwise) {
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>()
                                                         : otherwise;
}

std::string reference_state(const json& sensor) {
  const std::string state = text_or(sensor, "reference", "none");
  if (state == "none") return "no reference";
  std::string text = state == "stale" ? "referenced (stale: see reference.get)" : "referenced";
  const double introduced = sensor.value("reference_introduced_rms_waves", 0.0);
  if (introduced == 0.0) return text;
  return text + fmt::format(
                    "\nreference  contains an introduced aberration of {:.4f} wave RMS, and "
                    "coefficients are relative to it; for one without: ovws call "
                    "aberration.clear, then ovws call --wait reference.take",
                    introduced);
}

void print_failed_job(const json& failed) {
  const std::string field = text_or(failed, "field", "");
  print("failed     job {} ({}) at {}: {}{}\n", failed.at("job").get<int>(),
        text_or(failed, "kind", ""), text_or(failed, "t_failed", "?"),
        field.empty() ? "" : field + ": ", text_or(failed, "reason", ""));
}

/// Prints the faults of the sensor's layout, operator and frames; prints nothing for a null fault.
void print_sensor_faults(const json& sensor) {
  for (const char* key : {"layout_fault", "operator_reason"}) {
    if (sensor.contains(key) && sensor.at(key).is_string()) {
      print("sensor     {}: {}\n", key, text_or(sensor, key, ""));
    }
  }
  if (!sensor.contains("invalid") || !sensor.at("invalid").is_object()) return;
  const json& invalid = sensor.at("invalid");
  print("sensor     invalid: {}; {}\n", text_or(invalid, "reason", ""),
        text_or(invalid, "action", ""));
}

void print_status(const json& status, const json& loop, const json& aberration) {
  const json& camera = status.at("camera");
  const json& slm = status.at("slm");
  const json& sensor = status.at("sensor");
  print("state      {}\n", text_or(status, "state", "?"));
  if (camera.at("info").is_object()) {
    print("camera     {} {} at {}, {:.1f} frames/s\n", text_or(camera.at("info"), "vendor", ""),
          text_or(camera.at("info"), "model", ""), text_or(camera.at("info"), "address", ""),
          status.at("rates").at("grabbed_hz").get<double>());
  }
  if (camera.at("fault").is_string()) print("camera     {}\n", text_or(camera, "fault", ""));
  if (slm.at("info").is_object()) {
    print("slm        {} {}x{}, {} shown, hologram {}\n", text_or(slm.at("info"), "output", ""),
          slm.at("info").at("width").get<int>(), slm.at("info").at("height").get<int>(),
          text_or(slm, "pattern", ""), slm.at("hologram_id").get<std::uint64_t>());
  }
  if (slm.at("fault").is_string()) print("slm        {}\n", text_or(slm, "fault", ""));
  print("sensor     charge {}, {} subapertures, {} modes, tracker {}, {}\n",
        sensor.at("charge").get<int>(), sensor.at("subapertures").get<int>(),
        sensor.at("modes").get<int>(), text_or(sensor, "tracker", ""), reference_state(sensor));
  print_sensor_faults(sensor);
  const std::string introduced = modes_text(aberration.at("modes"));
  if (!introduced.empty()) print("aberration {} introduced\n", introduced);
  print("loop       {}\n", loop_text(loop));
  if (status.at("failed_job").is_object()) print_failed_job(status.at("failed_job"));
  if (status.contains("store") && status.at("store").at("reason").is_string()) {
    print("store      {}\n", text_or(status.at("store"), "reason", ""));
  }
  const json& refine = status.at("refine");
  if (text_or(refine, "state", "off") != "off") {
    print("refine     {}, {} done, {} refused{}\n", text_or(refine, "state", ""),
          refine.at("done").get<std::uint64_t>(), refine.at("refused").get<std::uint64_t>(),
          refine.at("reason").is_string() ? ": " + text_or(refine, "reason", "") : "");
  }
  for (const auto& [stage, latency] : status.at("latency").items()) {
    if (latency.at("count").get<std::uint64_t>() == 0) continue;
    print("latency    {:<14} p50 {:.0f} us, p99 {:.0f} us, max {:.0f} us\n", stage,
          latency.at("p50_us").get<double>(), latency.at("p99_us").get<double>(),
          latency.at("max_us").get<double>());
  }
  for (const auto& [name, count] : status.at("counters").items()) {
    if (count.get<std::uint64_t>() != 0) {
      print("counter    {} {}\n", name, count.get<std::uint64_t>());
    }
  }
}

void print_description(const json& description) {
  for (const auto& [name, schema] : description.at("methods").items()) {
    print("{:<20} {}\n", name, text_or(schema, "description", ""));
  }
  for (const auto& [name, schema] : description.at("streams").items()) {
    print("stream {:<13} {}\n", name, text_or(schema, "description", ""));
  }
}

/// Calls a method and prints the result with `show`, or as one line of JSON. Returns an exit code.
template <class Show>
int call_and_print(const Common& common, const std::string& method, const json& params, Show show) {
  const auto answer = call(common, method, params);
  if (!answer) return report_failure(common, answer.error());
  if (common.json) {
    print("{}\n", json_text(*answer));
  } else {
    show(*answer);
  }
  return kOk;
}

}  // namespace

int show_status(const Common& common) {
  const auto status = call(common, "system.status", json::object());
  if (!status) return report_failure(common, status.error());
  if (common.json) {
    print("{}\n", json_text(*status));
    return kOk;
  }
  const auto loop = call(common, "loop.get", json::object());
  if (!loop) return report_failure(common, loop.error());
  const auto aberration = call(common, "aberration.get", json::object());
  if (!aberration) return report_failure(common, aberration.error());
  print_status(*status, *loop, *aberration);
  return kOk;
}

int describe(const Common& common) {
  return call_and_print(common, "system.describe", json::object(), print_description);
}

}  // namespace ovws::cli
