/// Sentences for the results of methods that people call daily.
#include <fmt/chrono.h>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <numbers>
#include <vector>

#include "core/base/number_text.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/quantity.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

double number(const json& object, const char* key) {
  return object.at(key).get<double>();
}

bool is_true(const json& object, const char* key) {
  return object.at(key).get<bool>();
}

std::string text_or(const json& object, const char* key, const std::string& otherwise) {
  return object.at(key).is_string() ? object.at(key).get<std::string>() : otherwise;
}

std::string range_text(const json& limits, const char* key, std::string (*show)(double)) {
  if (!limits.is_object() || !limits.at(key).is_object()) return "";
  const json& range = limits.at(key);
  return fmt::format(" (the camera allows {} to {})", show(number(range, "min")),
                     show(number(range, "max")));
}

std::string decibels_text(double db) {
  return fmt::format("{:.4g} dB", db);
}
std::string hertz_text(double hertz) {
  return fmt::format("{:.4g} Hz", hertz);
}
std::string steps_text(double steps) {
  return fmt::format("{:.0f}", steps);
}

/// One further line that names spots or modes, if there are any.
std::string list_text(const json& result, const char* key, const char* what) {
  if (!result.contains(key) || result.at(key).empty()) return "";
  std::vector<std::string> all;
  for (const json& one : result.at(key)) all.push_back(one.dump());
  return fmt::format("\n{}: {}", what, fmt::join(all, ", "));
}

std::string camera_answer(const json& result) {
  const bool is_change = result.contains("applied");
  const std::string settings = camera_settings_text(result.at(is_change ? "applied" : "settings"));
  if (is_change || is_true(result, "connected")) return settings;
  return "no camera is connected; its settings will be:\n" + settings;
}

std::string cameras_answer(const json& result) {
  std::string text;
  for (const json& camera : result.at("cameras")) {
    const std::string address = text_or(camera, "address", "");
    text += fmt::format("{}{}{}{}", text.empty() ? "" : "\n", text_or(camera, "id", "?"),
                        address.empty() ? "" : " at " + address,
                        is_true(camera, "selected") ? " (selected)" : "");
  }
  return text.empty() ? "no camera answers: check power, cable and network, or run ovws doctor"
                      : text;
}

std::string outputs_answer(const json& result) {
  std::string text;
  for (const json& output : result.at("outputs")) {
    const std::string reason = text_or(output, "reason", "");
    text +=
        fmt::format("{}{}{}: {}{}", text.empty() ? "" : "\n", text_or(output, "name", "?"),
                    is_true(output, "selected") ? " (selected)" : "",
                    is_true(output, "on") ? fmt::format("{} x {}, ", output.at("width").get<int>(),
                                                        output.at("height").get<int>())
                                          : "",
                    reason.empty() ? "usable" : reason);
  }
  return text.empty() ? "the display system has no outputs" : text;
}

std::string slm_settings_answer(const json& result) {
  return fmt::format("SLM on output {}{}, settle time {:g} ms", text_or(result, "display", "?"),
                     is_true(result, "allow_primary") ? ", which may be the primary one" : "",
                     number(result, "settle_ms"));
}

std::string exposure_answer(const json& result) {
  const int saturated = result.at("saturated_pixels").get<int>();
  return fmt::format(
      "exposure {}, gain {}: most spots reach up to {:.0f} % of full scale, {}",
      exposure_text(result, {}), gain_text(result, {}), 100.0 * number(result, "brightest"),
      saturated == 0 ? "no pixel is saturated" : fmt::format("{} pixels are saturated", saturated));
}

std::string aberration_answer(const json& result) {
  const std::string modes = modes_text(result.at("modes"));
  const std::size_t patterns = result.value("patterns", json::array()).size();
  if (patterns > 0) return fmt::format("a sequence of patterns is shown: {}", patterns);
  return modes.empty() ? "no aberration is introduced" : "introduced aberration: " + modes;
}

std::string correction_answer(const json& result) {
  const std::string modes = modes_text(result.at("modes"));
  return modes.empty() ? "no correction is shown" : "correction: " + modes;
}

std::string taken_reference(const json& result) {
  std::string text = fmt::format("reference taken from {} frames: noise {:.4f} px, drift {:.4f} px",
                                 result.at("frames").get<int>(), number(result, "noise_px"),
                                 number(result, "drift_px"));
  if (number(result, "introduced_rms_waves") > 0.0) {
    text += fmt::format("\nit contains the introduced aberration of {:.4f} wave RMS",
                        number(result, "introduced_rms_waves"));
  }
  return text + list_text(result, "lost_spots", "lost spots") +
         list_text(result, "weak_spots", "weak spots") +
         list_text(result, "saturated_spots", "saturated spots") +
         list_text(result, "weak_modes", "weak modes");
}

std::string reference_answer(const json& result) {
  return "reference: " + reference_text(result);
}

std::string references_answer(const json& result) {
  std::string text;
  for (const json& one : result.at("references")) {
    const std::string reason = text_or(one, "reason", "");
    text += fmt::format("{}{}: taken {}{}", text.empty() ? "" : "\n", text_or(one, "name", "?"),
                        age_text(one.at("t_taken_ns").get<std::int64_t>()),
                        reason.empty() ? "" : ", does not fit: " + reason);
  }
  return text.empty() ? "no reference is saved; save the active one with ovws reference save NAME"
                      : text;
}

std::string recordings_answer(const json& result) {
  if (!result.at("folder").is_string()) return "no folder for recordings is configured";
  std::string text = "recordings in " + text_or(result, "folder", "");
  for (const json& one : result.at("recordings")) {
    text += fmt::format("\n{}: {}, {}", text_or(one, "name", "?"), size_text(number(one, "bytes")),
                        age_text(one.at("t_modified_ns").get<std::int64_t>()));
  }
  const int left_off = result.at("left_off").get<int>();
  return left_off == 0 ? text : text + fmt::format("\nand {} older ones", left_off);
}

std::string lut_answer(const json& result) {
  if (!is_true(result, "measured")) {
    return fmt::format("LUT: {}, not measured; measure it with ovws call --wait lut.run",
                       text_or(result, "source", "linear"));
  }
  std::string text = fmt::format("LUT: {:.2f} pi deep, error {:.2g} mrad",
                                 number(result, "depth_rad") / std::numbers::pi,
                                 1e3 * number(result, "residual_rad"));
  if (result.at("falls") == true) text += ", the phase falls with the grey level";
  if (result.at("reaches_2pi") == false) text += ", does not reach 2 pi";
  const std::string reason = text_or(result, "reason", "");
  return reason.empty() ? text : text + "\n" + reason;
}

std::string registration_answer(const json& result) {
  if (!is_true(result, "registered")) return "no registration: ovws call --wait registration.run";
  const json& base = result.at("base_px");
  return fmt::format(
      "registration: rotation {:.2f} deg, {}, scale {:.1f} px per cycle per SLM pixel\n"
      "base spot at ({:.1f}, {:.1f}) px, residual {:.3f} px at {} positions",
      number(result, "rotation_deg"), is_true(result, "mirrored") ? "mirrored" : "not mirrored",
      number(result, "scale_px_per_cycle"), base.at(0).get<double>(), base.at(1).get<double>(),
      number(result, "residual_px"), result.at("sights").get<int>());
}

std::string map_answer(const json& result) {
  return fmt::format(
      "map: error {:.4f} wave RMS in cells of {:.1f} px ({:.1f} px resolved), noise {:.4f}\n"
      "the flatness in use removes {:.4f}, and differs from the map by {:.4f}{}",
      number(result, "rms_waves"), number(result, "cell_px"), number(result, "resolution_px"),
      number(result, "standard_error_waves"), number(result, "flatness_rms_waves"),
      number(result, "difference_rms_waves"),
      is_true(result, "applied") ? "\nthe map is the flatness from now on" : "");
}

std::string flatness_answer(const json& result) {
  if (!is_true(result, "measured")) return "flatness: not measured: ovws call --wait flatness.run";
  return fmt::format("flatness: {:.4f} wave RMS is corrected, change of the last scan {:.4f} wave",
                     number(result, "rms_waves"), number(result, "residual_rms_waves"));
}

/// Root sum square of the modes of one radial order n and azimuthal frequency +-m.
double rms_of(const json& modes, int n, int m) {
  double squares = 0.0;
  for (const json& mode : modes) {
    if (mode.at("n") != n || std::abs(mode.at("m").get<int>()) != m) continue;
    squares += number(mode, "waves") * number(mode, "waves");
  }
  return std::sqrt(squares);
}

std::string focus_answer(const json& result) {
  const double shift_mm = number(result, "camera_shift_mm");
  const double error_mm = number(result, "camera_shift_standard_error_mm");
  // The rounds of focus.run end at a change of 0.003 wave: less is not worth a move of the camera.
  constexpr double kAccuracyWaves = 0.003;
  const double error_waves = number(result, "defocus_standard_error_waves");
  const double within_mm = error_mm * std::max(2.0, kAccuracyWaves / error_waves);
  const bool is_focused = std::abs(shift_mm) <= within_mm;
  const json& modes = result.at("modes");
  std::string text = is_focused
                         ? fmt::format("the camera is in focus, within {:.3f} mm", within_mm)
                         : fmt::format(
                               "the camera is {0:.3f} mm {1} the focus: move it {2} the lens by "
                               "{0:.3f} mm",
                               std::abs(shift_mm), shift_mm > 0.0 ? "behind" : "in front of",
                               shift_mm > 0.0 ? "towards" : "away from");
  text += fmt::format(
      "\ndefocus {} wave RMS (standard error {:.4f}), astigmatism {:.4f}, coma {:.4f}, "
      "spherical aberration {:.4f}",
      signed_decimals(number(result, "defocus_waves"), 4),
      number(result, "defocus_standard_error_waves"), rms_of(modes, 2, 2), rms_of(modes, 3, 1),
      rms_of(modes, 4, 0));
  if (!result.at("flatness_defocus_waves").is_number()) return text;
  return text + fmt::format(
                    "\nnot in it: {} wave of defocus that the flatness compensates; to focus "
                    "the camera itself, call flatness.clear first",
                    signed_decimals(number(result, "flatness_defocus_waves"), 4));
}

std::string settle_answer(const json& result) {
  const std::string reason = text_or(result, "reason", "");
  if (!reason.empty()) return "settle time: " + reason;
  return fmt::format(
      "settle time: {:.1f} ms (median), {:.1f} ms at most\nslm.settle_ms is {:g} ms, {}; with the "
      "usual margin: {:g} ms",
      number(result, "p50_ms"), number(result, "worst_ms"), number(result, "configured_settle_ms"),
      is_true(result, "long_enough") ? "long enough" : "TOO SHORT",
      number(result, "proposed_settle_ms"));
}

std::string verify_answer(const json& result) {
  const auto hologram = result.at("hologram_id").get<std::uint64_t>();
  if (is_true(result, "equal"))
    return fmt::format("the output shows hologram {} exactly", hologram);
  return fmt::format("the output does NOT show hologram {}: {} pixels differ", hologram,
                     result.at("differing_pixels").dump());
}

std::string show_answer(const json& result) {
  return fmt::format("the SLM shows: {} (hologram {})", text_or(result, "pattern", "?"),
                     result.at("hologram_id").get<std::uint64_t>());
}

std::string calibration_answer(const json& result) {
  if (!is_true(result, "calibrated")) return "no calibration: ovws call --wait calibration.run";
  std::string text =
      fmt::format("calibration: {} modes, {} frames each, condition number {:.1f}, drift {:.4f} px",
                  result.at("modes").size(), result.at("frames").get<int>(),
                  number(result, "condition_number"), number(result, "drift_px"));
  if (text_or(result, "source", "") == "set") text += "\ngiven by a client (calibration.set)";
  if (!is_true(result, "in_force")) text += "\nnot active: taken with other settings";
  for (const json& mode : result.at("dropped")) {
    text += fmt::format("\ndropped {}: {}", zernike_name(mode.at("j").get<int>()),
                        text_or(mode, "reason", ""));
  }
  const std::string reason = text_or(result, "disagreement_reason", "");
  return reason.empty() ? text : text + "\n" + reason;
}

std::string loop_answer(const json& result) {
  return "loop " + loop_text(result);
}

std::string record_answer(const json& result) {
  return "recording " + record_text(result);
}

std::string saved_answer(const json& result) {
  std::string text;
  for (const json& key : result.at("saved")) {
    text += (text.empty() ? ": " : ", ") + key.get<std::string>();
  }
  return "saved in " + text_or(result, "path", "?") +
         (text.empty() ? ": nothing differs from the configuration" : text);
}

std::string job_answer(const json& result) {
  const std::string state = result.at("state").get<std::string>();
  const std::string kind = result.at("kind").get<std::string>();
  std::string text = fmt::format("job {} ({}): {}", result.at("job").get<int>(), kind, state);
  if (state == "running") text += fmt::format(", {:.0f} %", 100.0 * number(result, "progress"));
  if (state == "failed") text += ": " + result.at("error").at("message").get<std::string>();
  return state == "done" ? text + "\n" + answer_text(kind, result.at("result")) : text;
}

using Sentence = std::string (*)(const json&);
const std::map<std::string, Sentence> kSentences{{"aberration.clear", aberration_answer},
                                                 {"aberration.get", aberration_answer},
                                                 {"aberration.sequence", aberration_answer},
                                                 {"aberration.set", aberration_answer},
                                                 {"calibration.clear", calibration_answer},
                                                 {"calibration.get", calibration_answer},
                                                 {"calibration.run", calibration_answer},
                                                 {"camera.auto_exposure", exposure_answer},
                                                 {"camera.get", camera_answer},
                                                 {"camera.list", cameras_answer},
                                                 {"camera.select", camera_answer},
                                                 {"camera.set", camera_answer},
                                                 {"config.save", saved_answer},
                                                 {"correction.clear", correction_answer},
                                                 {"correction.get", correction_answer},
                                                 {"correction.set", correction_answer},
                                                 {"flatness.clear", flatness_answer},
                                                 {"flatness.get", flatness_answer},
                                                 {"flatness.run", flatness_answer},
                                                 {"focus.run", focus_answer},
                                                 {"job.cancel", job_answer},
                                                 {"job.get", job_answer},
                                                 {"loop.close", loop_answer},
                                                 {"loop.get", loop_answer},
                                                 {"loop.open", loop_answer},
                                                 {"loop.pause", loop_answer},
                                                 {"lut.clear", lut_answer},
                                                 {"lut.get", lut_answer},
                                                 {"lut.run", lut_answer},
                                                 {"map.run", map_answer},
                                                 {"record.get", record_answer},
                                                 {"record.list", recordings_answer},
                                                 {"record.start", record_answer},
                                                 {"record.stop", record_answer},
                                                 {"reference.clear", reference_answer},
                                                 {"reference.get", reference_answer},
                                                 {"reference.delete", references_answer},
                                                 {"reference.list", references_answer},
                                                 {"reference.load", reference_answer},
                                                 {"reference.save", references_answer},
                                                 {"reference.set", reference_answer},
                                                 {"reference.take", taken_reference},
                                                 {"registration.clear", registration_answer},
                                                 {"registration.get", registration_answer},
                                                 {"registration.run", registration_answer},
                                                 {"slm.outputs", outputs_answer},
                                                 {"slm.set", slm_settings_answer},
                                                 {"slm.settle", settle_answer},
                                                 {"slm.show", show_answer},
                                                 {"slm.verify", verify_answer}};

}  // namespace

std::string camera_settings_text(const json& settings) {
  const json& roi = settings.at("roi");
  return fmt::format("exposure {}, gain {}, {:.4g} frames/s, {}, region {} x {} at ({}, {})",
                     exposure_text(settings, {}), gain_text(settings, {}),
                     number(settings, "frame_rate_hz"), text_or(settings, "pixel_format", "?"),
                     roi.at("width").get<int>(), roi.at("height").get<int>(),
                     roi.at("x").get<int>(), roi.at("y").get<int>());
}

std::string exposure_text(const json& settings, const json& limits) {
  return time_text(1e-6 * number(settings, "exposure_us")) +
         range_text(limits, "exposure_us", [](double us) { return time_text(1e-6 * us); });
}

std::string gain_text(const json& settings, const json& limits) {
  if (settings.at("gain_db").is_number()) {
    return decibels_text(number(settings, "gain_db")) +
           range_text(limits, "gain_db", decibels_text);
  }
  if (!settings.at("gain_raw").is_number()) return "unknown";
  return steps_text(number(settings, "gain_raw")) + " steps" +
         range_text(limits, "gain_raw", steps_text);
}

std::string rate_text(const json& settings, const json& limits) {
  return hertz_text(number(settings, "frame_rate_hz")) +
         range_text(limits, "frame_rate_hz", hertz_text);
}

std::string modes_text(const json& modes) {
  double square = 0.0;
  std::string text;
  for (const json& mode : modes) {
    const double waves = number(mode, "waves");
    if (waves == 0.0) continue;
    square += waves * waves;
    text += fmt::format(", {} {}", text_or(mode, "name", "?"), signed_decimals(waves, 4));
  }
  return text.empty() ? "" : fmt::format("{:.4f} wave RMS{}", std::sqrt(square), text);
}

std::string reference_text(const json& reference) {
  if (!is_true(reference, "taken")) return "none; take one with ovws reference 100";
  const std::string age = age_text(reference.at("t_taken_ns").get<std::int64_t>());
  std::string text =
      text_or(reference, "source", "") == "model"
          ? "from the model, set " + age
          : fmt::format("measured {} from {} frames", age, reference.at("frames").get<int>());
  for (const json& one : reference.at("stale")) {
    text += fmt::format(", STALE: {} was {}, is {}", one.at("field").get<std::string>(),
                        one.at("then").dump(), one.at("now").dump());
  }
  return text;
}

std::string loop_text(const json& loop) {
  const bool closed = is_true(loop, "closed");
  const auto steps = loop.at("steps").get<std::int64_t>();
  std::string text = is_true(loop, "paused") ? "paused" : closed ? "closed" : "open";
  if (closed || steps > 0) {
    text += fmt::format(", {} steps, correction {:.4f} wave RMS", steps,
                        number(loop, "correction_rms_waves"));
  }
  if (loop.at("residual_rms_waves").is_number()) {
    text += fmt::format(", residual {:.4f} wave RMS", number(loop, "residual_rms_waves"));
  }
  if (loop.at("opened_because").is_string()) {
    text += fmt::format(", opened at {}: {}", text_or(loop, "t_opened", "?"),
                        text_or(loop, "opened_because", ""));
  }
  return text;
}

std::string record_text(const json& record) {
  if (text_or(record, "state", "off") == "off") return "off";
  const auto count = [&](const char* key) { return record.at(key).get<std::uint64_t>(); };
  std::string text = fmt::format("{}: {}, {} frames, {} images, {}", text_or(record, "file", "?"),
                                 time_text(number(record, "duration_s")), count("frames"),
                                 count("pictures"), size_text(number(record, "bytes")));
  if (count("frames_dropped") > 0) text += fmt::format(", {} frames LOST", count("frames_dropped"));
  if (count("pictures_dropped") > 0) {
    text += fmt::format(", {} images LOST", count("pictures_dropped"));
  }
  if (count("documents_dropped") > 0) {
    text += fmt::format(", {} documents LOST", count("documents_dropped"));
  }
  if (text_or(record, "state", "") == "ended") text += "; ended: " + text_or(record, "reason", "?");
  return text;
}

std::string event_text(const json& event) {
  const std::time_t second = event.at("t_ns").get<std::int64_t>() / 1'000'000'000;
  const std::string severity = text_or(event, "severity", "");
  return fmt::format("{:%H:%M:%S} {}{}: {}", fmt::localtime(second),
                     severity == "info" ? "" : severity + " ", text_or(event, "kind", "?"),
                     text_or(event, "text", ""));
}

std::string answer_text(const std::string& method, const json& result) {
  if (result.is_object() && result.size() == 1 && result.contains("job")) {
    const std::string job = result.at("job").dump();
    return fmt::format(
        "job {0} has begun; ovws call job.get job={0} reports it, and --wait waits "
        "for it",
        job);
  }
  const auto found = kSentences.find(method);
  return found == kSentences.end() ? summary_text(result) : found->second(result);
}

}  // namespace ovws::cli
