/// Sentences for the results of methods that people call daily.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/base/number_text.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "daemon/ovws/text/quantity.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

double number(const json& object, const char* key) {
  return object.at(key).get<double>();
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
  // What the noise does not explain: less is not worth a move of the camera.
  constexpr double kAccuracyWaves = 0.003;
  const double error_waves = number(result, "defocus_standard_error_waves");
  const double within_mm = error_mm * std::max(2.0, kAccuracyWaves / error_waves);
  const json& modes = result.at("modes");
  json said = result;
  said.update({{"within_mm", within_mm},
               {"is_focused", std::abs(shift_mm) <= within_mm},
               {"is_behind", shift_mm > 0.0},
               {"distance_mm", std::abs(shift_mm)},
               {"astigmatism", rms_of(modes, 2, 2)},
               {"coma", rms_of(modes, 3, 1)},
               {"spherical", rms_of(modes, 4, 0)},
               {"has_flatness", result.at("flatness_defocus_waves").is_number()}});
  return fill(
      "[is_focused?the camera is in focus, within {within_mm:.3f} mm]"
      "[!is_focused?the camera is {distance_mm:.3f} mm "
      "[is_behind?behind the focus: move it towards][!is_behind?in front of the focus: move it "
      "away from] the lens by {distance_mm:.3f} mm]\n"
      "defocus {defocus_waves:signed} wave RMS (standard error "
      "{defocus_standard_error_waves:.4f}), "
      "astigmatism {astigmatism:.4f}, coma {coma:.4f}, spherical aberration {spherical:.4f}"
      "[has_flatness?\nnot in it: {flatness_defocus_waves:signed} wave of defocus that the "
      "flatness compensates; to focus the camera itself, call flatness.clear first]",
      said);
}

std::string job_answer(const json& result) {
  const std::string text = fill(
      "job {job} ({kind}): {state}[state=running?, {progress*100:.0f} %]"
      "[state=failed?: {error.message}]",
      result);
  if (result.at("state") != "done") return text;
  return text + "\n" + answer_text(result.at("kind").get<std::string>(), result.at("result"));
}

constexpr const char* kReference =
    "[!taken?none; take one with ovws reference 100]"
    "[taken?[source=model?from the model, set {t_taken_ns:age}]"
    "[!source=model?measured {t_taken_ns:age} from {frames} frames]"
    "[stale*, STALE: {field} was {then:json}, is {now:json}]]";
constexpr const char* kLoop =
    "[paused?paused][!paused?[closed?closed][!closed?open]]"
    "[closed|steps?, {steps} steps, correction {correction_rms_waves:.4f} wave RMS]"
    "[residual_rms_waves?, residual {residual_rms_waves:.4f} wave RMS]"
    "[opened_because?, opened at {t_opened}: {opened_because}]";
constexpr const char* kRecord =
    "[state=off?off][!state=off?{file}: {duration_s:time}, {frames} frames, {pictures} images, "
    "{bytes:size}[frames_dropped?, {frames_dropped} frames LOST]"
    "[pictures_dropped?, {pictures_dropped} images LOST]"
    "[documents_dropped?, {documents_dropped} documents LOST][state=ended?; ended: {reason}]]";

/// Templates for the results of methods.
struct Form {
  const char* methods;  ///< with a space after each
  const char* text;
};
constexpr Form kForms[]{
    {"aberration.clear aberration.get aberration.sequence aberration.set ",
     "[patterns?a sequence of patterns is shown: {patterns:count}]"
     "[!patterns?[modes:modes?introduced aberration: {modes:modes}]"
     "[!modes:modes?no aberration is introduced]]"},
    {"calibration.clear calibration.get calibration.run ",
     "[!calibrated?no calibration: ovws call --wait calibration.run]"
     "[calibrated?calibration: {modes:count} modes, {frames} frames each, condition number "
     "{condition_number:.1f}, drift {drift_px:.4f} px"
     "[source=set?\ngiven by a client (calibration.set)]"
     "[!in_force?\nnot active: taken with other settings]"
     "[dropped*\ndropped {j:mode}: {reason}][disagreement_reason?\n{disagreement_reason}]]"},
    {"camera.auto_exposure ",
     "exposure {.:exposure}, gain {.:gain}: most spots reach up to {brightest*100:.0f} % of full "
     "scale, [saturated_pixels?{saturated_pixels} pixels are saturated]"
     "[!saturated_pixels?no pixel is saturated]"},
    {"camera.get camera.select camera.set ",
     "[applied?{applied:camera}][!applied?[!connected?no camera is connected; its settings will "
     "be:\n]{settings:camera}]"},
    {"camera.list ",
     "[cameras*{id}[address? at {address}][selected? (selected)]\n]"
     "[!cameras?no camera answers: check power, cable and network, or run ovws doctor]"},
    {"config.save ",
     "saved in {path}: [saved?{saved:list}][!saved?nothing differs from the configuration]"},
    {"correction.clear correction.get correction.set ",
     "[modes:modes?correction: {modes:modes}][!modes:modes?no correction is shown]"},
    {"flatness.clear flatness.get flatness.run ",
     "flatness: [!measured?not measured: ovws call --wait flatness.run]"
     "[measured?{rms_waves:.4f} wave RMS is corrected, change of the last scan "
     "{residual_rms_waves:.4f} wave]"},
    {"lut.clear lut.get lut.run ",
     "LUT: [!measured?[source?{source}][!source?linear], not measured; measure it with ovws call "
     "--wait lut.run]"
     "[measured?{depth_rad/3.14159265358979:.2f} pi deep, error {residual_rad*1000:.2g} mrad"
     "[falls?, the phase falls with the grey level][reaches_2pi=false?, does not reach 2 pi]"
     "[reason?\n{reason}]]"},
    {"map.run ",
     "map: error {rms_waves:.4f} wave RMS in cells of {cell_px:.1f} px ({resolution_px:.1f} px "
     "resolved), noise {standard_error_waves:.4f}\n"
     "the flatness in use removes {flatness_rms_waves:.4f}, and differs from the map by "
     "{difference_rms_waves:.4f}[applied?\nthe map is the flatness from now on]"},
    {"record.list ",
     "[!folder?no folder for recordings is configured][folder?recordings in {folder}"
     "[recordings*\n{name}: {bytes:size}, {t_modified_ns:age}]"
     "[left_off?\nand {left_off} older ones]]"},
    {"reference.delete reference.list reference.save ",
     "[references*{name}: taken {t_taken_ns:age}[reason?, does not fit: {reason}]\n]"
     "[!references?no reference is saved; save the active one with ovws reference save NAME]"},
    {"reference.take ",
     "reference taken from {frames} frames: noise {noise_px:.4f} px, drift {drift_px:.4f} px"
     "[introduced_rms_waves?\nit contains the introduced aberration of "
     "{introduced_rms_waves:.4f} wave RMS][lost_spots?\nlost spots: {lost_spots:list}]"
     "[weak_spots?\nweak spots: {weak_spots:list}]"
     "[saturated_spots?\nsaturated spots: {saturated_spots:list}]"
     "[weak_modes?\nweak modes: {weak_modes:list}]"},
    {"registration.clear registration.get registration.run ",
     "[!registered?no registration: ovws call --wait registration.run]"
     "[registered?registration: rotation {rotation_deg:.2f} deg, [!mirrored?not ]mirrored, scale "
     "{scale_px_per_cycle:.1f} px per cycle per SLM pixel\n"
     "base spot at ({base_px.0:.1f}, {base_px.1:.1f}) px, residual {residual_px:.3f} px at "
     "{sights} positions]"},
    {"slm.outputs ",
     "[outputs*{name}[selected? (selected)]: [on?{width} x {height}, ]"
     "[reason?{reason}][!reason?usable]\n][!outputs?the display system has no outputs]"},
    {"slm.set ",
     "SLM on output {display}[allow_primary?, which may be the primary one], settle time "
     "{settle_ms:g} ms"},
    {"slm.settle ",
     "settle time: [reason?{reason}][!reason?{p50_ms:.1f} ms (median), {worst_ms:.1f} ms at most\n"
     "slm.settle_ms is {configured_settle_ms:g} ms, [long_enough?long enough]"
     "[!long_enough?TOO SHORT]; with the usual margin: {proposed_settle_ms:g} ms]"},
    {"slm.show ", "the SLM shows: {pattern} (hologram {hologram_id})"},
    {"slm.verify ",
     "the output [equal?shows hologram {hologram_id} exactly][!equal?does NOT show hologram "
     "{hologram_id}: {differing_pixels:json} pixels differ]"}};

using Sentence = std::string (*)(const json&);
constexpr std::pair<const char*, Sentence> kSentences[]{
    {"focus.run ", focus_answer},
    {"job.cancel job.get ", job_answer},
    {"loop.close loop.get loop.open loop.pause ",
     [](const json& result) { return "loop " + loop_text(result); }},
    {"record.get record.start record.stop ",
     [](const json& result) { return "recording " + record_text(result); }},
    {"reference.clear reference.get reference.load reference.set ",
     [](const json& result) { return "reference: " + reference_text(result); }}};

}  // namespace

std::string camera_settings_text(const json& settings) {
  return fill(
      "exposure {.:exposure}, gain {.:gain}, {frame_rate_hz:.4g} frames/s, {pixel_format}, region "
      "{roi.width} x {roi.height} at ({roi.x}, {roi.y})",
      settings);
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
  return fill(kReference, reference);
}

std::string loop_text(const json& loop) {
  return fill(kLoop, loop);
}

std::string record_text(const json& record) {
  return fill(kRecord, record);
}

std::string event_text(const json& event) {
  return fill("{t_ns:clock} [!severity=info?{severity} ]{kind}: {text}", event);
}

std::string answer_text(const std::string& method, const json& result) {
  if (result.is_object() && result.size() == 1 && result.contains("job")) {
    return fill(
        "job {job} has begun; ovws call job.get job={job} reports it, and --wait waits for it",
        result);
  }
  const auto is_of = [&method](const std::string& methods) {
    return (" " + methods).find(" " + method + " ") != methods.npos;
  };
  for (const Form& form : kForms) {
    if (is_of(form.methods)) return fill(form.text, result);
  }
  for (const auto& [methods, sentence] : kSentences) {
    if (is_of(methods)) return sentence(result);
  }
  return summary_text(result);
}

}  // namespace ovws::cli
