#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "daemon/examine/check/judge.hpp"
#include "daemon/examine/in_use.hpp"

namespace ovws::examine {
namespace {

using nlohmann::json;

constexpr double kHourS = 3600.0, kDayS = 24.0 * kHourS;
constexpr double kOldReferenceS = 12.0 * kHourS;
constexpr double kOldMeasurementS = 90.0 * kDayS;  // of registration, LUT and flatness

/// Seconds from the time of a measurement to the begin of the check.
double age_s(const Measured& measured, const json& of) {
  return 1e-9 * double(measured.t_ns - of.at("t_taken_ns").get<std::int64_t>());
}

std::string age_text(double seconds) {
  if (seconds < 120.0) return fmt::format("{:.0f} s old", std::max(0.0, seconds));
  if (seconds < 2.0 * kHourS) return fmt::format("{:.0f} min old", seconds / 60.0);
  if (seconds < 2.0 * kDayS) return fmt::format("{:.0f} h old", seconds / kHourS);
  return fmt::format("{:.0f} days old", seconds / kDayS);
}

/// λ/d of a subaperture, camera pixels.
double spot_px(const Measured& measured, double scale) {
  return scale * measured.sensor.at("subapertures_across").get<double>() /
         measured.sensor.at("pupil_diameter_px").get<double>();
}

/// Adds the age of what was measured, which is worth a note from `old_s` on.
void add_age(Finding& found, const Measured& measured, const json& of,
             double old_s = kOldMeasurementS) {
  const double age = age_s(measured, of);
  found.text += ", " + age_text(age);
  if (age > old_s) found.severity = std::max(found.severity, Severity::note);
}

void raise(Finding& found, Severity verdict, const std::string& text) {
  found.severity = std::max(found.severity, verdict);
  found.text += "; " + text;
}

/// RMS error of the phase that a table shows; `sign` -1: for a hologram that is shown conjugated.
double error_as_waves(const json& grey_levels, const json& phase_rad, double sign) {
  const std::size_t count = grey_levels.size();
  std::vector<double> errors;
  std::complex<double> sum;
  for (std::size_t k = 0; k < count; ++k) {
    const double shown = phase_rad.at(grey_levels.at(k).get<std::size_t>()).get<double>();
    errors.push_back(sign * shown - 2.0 * std::numbers::pi * double(k) / double(count));
    sum += std::polar(1.0, errors.back());
  }
  double squares = 0.0;
  for (const double error : errors) {
    squares += std::pow(std::arg(std::polar(1.0, error) * std::conj(sum)), 2);
  }
  return std::sqrt(squares / double(count)) / (2.0 * std::numbers::pi);
}

Finding judge_reference(const MeasuredFacts& facts) {
  constexpr double kGood = 0.01, kWarning = 0.1;
  const Measured& measured = facts.measured;
  Finding found;
  found.limit = fmt::format("at most {:g} h old, present wavefront within {} wave RMS of it",
                            kOldReferenceS / kHourS, kGood);
  found.fix = "ovws reference 100";
  const json& reference = measured.reference;
  if (reference.at("source") == "model") {
    found.severity = Severity::note;
    found.text = "the reference is that of the model, which knows no aberration of the bench";
  } else {
    found.text = fmt::format("{} frames", reference.at("frames").get<int>());
    add_age(found, measured, reference, kOldReferenceS);
  }
  const json& stale = reference.at("stale");
  if (!stale.empty()) {
    raise(found, Severity::warning,
          fmt::format("{} has changed since then", stale.at(0).at("field").get<std::string>()));
  }
  const double introduced = reference.at("introduced_rms_waves").is_number()
                                ? reference.at("introduced_rms_waves").get<double>()
                                : 0.0;
  if (introduced > 0.0) {
    raise(found, Severity::warning,
          fmt::format("contains an introduced aberration of {:.4f} wave RMS", introduced));
    found.fix = "ovws clear && ovws reference 100";
  }
  if (!facts.open.usable || facts.open.offset <= kGood) return found;
  raise(found, facts.open.offset > kWarning ? Severity::warning : Severity::note,
        fmt::format("the present wavefront differs from it by {:.4f} wave RMS", facts.open.offset));
  found.cost_waves = facts.open.offset;
  if (introduced == 0.0) found.fix = "ovws loop close";
  return found;
}

Finding judge_registration(const MeasuredFacts& facts) {
  constexpr double kGoodShare = 0.02, kBadShare = 0.1, kScale = 0.01;
  const Measured& measured = facts.measured;
  const json& registration = measured.registration;
  const double configured = configured_px_per_cycle(measured.config);
  const double spot = spot_px(measured, configured);
  Finding found;
  found.limit =
      fmt::format("residual at most {:.2f} px, scale within {:.0f} % of the configuration",
                  kGoodShare * spot, 100.0 * kScale);
  found.fix = "ovws call registration.run --wait && ovws reference 100";
  if (!registration.at("registered").get<bool>()) {
    found.severity = Severity::note;
    found.text =
        "none was measured: the spots are expected where the configuration puts them, on a camera "
        "that is neither rotated nor mirrored";
    return found;
  }
  const double scale = registration.at("scale_px_per_cycle").get<double>();
  const double residual = registration.at("residual_px").get<double>();
  found.text =
      fmt::format("scale {:.4f} of the configuration's, rotation {:.2f}°, {}, residual {:.3f} px",
                  scale / configured, registration.at("rotation_deg").get<double>(),
                  registration.at("mirrored").get<bool>() ? "mirrored" : "not mirrored", residual);
  found.severity = severity_of(residual / spot, kGoodShare, kGoodShare, kBadShare);
  add_age(found, measured, registration);
  if (std::abs(scale / configured - 1.0) > kScale) {
    raise(found, Severity::note,
          "focal length, magnification or a pixel pitch of the configuration is not exact; the "
          "measured scale is used");
    found.fix = "ovws call config.get";
  }
  return found;
}

Finding judge_lut(const MeasuredFacts& facts) {
  constexpr double kGood = 0.008, kBad = 0.1;
  const Measured& measured = facts.measured;
  Finding found;
  found.limit =
      fmt::format("error at most {} wave RMS (0.8 % of 2 pi); bad above {} wave", kGood, kBad);
  found.fix = "ovws call lut.run --wait && ovws reference 100";
  const json& lut = measured.lut;
  const bool in_use = lut.at("measured").get<bool>();
  const json& known = in_use ? lut : measured.lut_run.result;
  if (!known.is_object()) {
    found.severity = Severity::note;
    found.text = fmt::format("the {} table is used; the SLM's phase is not measured: {}",
                             lut.at("source").get<std::string>(), measured.lut_run.reason);
    return found;
  }
  const double depth = std::abs(known.at("depth_rad").get<double>());
  found.cost_waves = table_error_waves(lut.at("grey_levels"), known.at("phase_rad"));
  found.severity = severity_of(found.cost_waves, kGood, kGood, kBad);
  found.text = fmt::format(
      "the {} table is used; its error is {:.4f} wave RMS, and the SLM's depth {:.3f} times 2 pi",
      lut.at("source").get<std::string>(), found.cost_waves,
      depth / (2.0 * std::numbers::pi) * 256.0 / 255.0);
  if (in_use) add_age(found, measured, lut);
  return found;
}

Finding judge_flatness(const MeasuredFacts& facts) {
  constexpr double kGood = 0.01;
  const json& flatness = facts.measured.flatness;
  Finding found;
  found.limit = fmt::format("measured, and at most {} wave RMS is left", kGood);
  found.fix = "ovws call flatness.run --wait && ovws reference 100";
  if (!flatness.at("measured").get<bool>()) {
    found.severity = Severity::note;
    found.text = flatness.at("path").is_string()
                     ? "a file is used: " + flatness.at("path").get<std::string>()
                     : "not measured: the reference contains the SLM's own shape";
    return found;
  }
  const double left = flatness.at("residual_rms_waves").get<double>();
  found.text = fmt::format("{:.4f} wave RMS are corrected, {:.4f} are left",
                           flatness.at("rms_waves").get<double>(), left);
  found.cost_waves = left;
  found.severity = severity_of(left, kGood, 5.0 * kGood, 1.0);
  add_age(found, facts.measured, flatness);
  return found;
}

Finding judge_calibration(const MeasuredFacts& facts) {
  const json& calibration = facts.measured.calibration;
  const json& sensor = facts.measured.sensor;
  Finding found;
  found.limit = "in use, if there is one";
  found.fix = "ovws call calibration.run --wait";
  if (!calibration.at("calibrated").get<bool>()) {
    found.text = "none: the model's matrix is used";
    return found;
  }
  found.text = fmt::format("{} modes, {}", calibration.at("modes").size(),
                           age_text(age_s(facts.measured, calibration)));
  if (calibration.at("in_force").get<bool>()) return found;
  found.severity = Severity::note;
  found.text += "; not in use";
  if (sensor.at("operator_reason").is_string()) {
    found.text += ": " + sensor.at("operator_reason").get<std::string>();
  }
  return found;
}

constexpr std::array<Question<MeasuredFacts>, 5> kBench{{
    {"reference", judge_reference, kNothing, kAll, "Reference"},
    {"registration", judge_registration, kNothing, kAll, "Registration"},
    {"lut", judge_lut, kNothing, kAll, "Look-up table of the SLM"},
    {"flatness", judge_flatness, kNothing, kAll, "Flatness of the SLM"},
    {"calibration", judge_calibration, kNothing, kAll, "Calibration"},
}};

}  // namespace

double table_error_waves(const json& grey_levels, const json& phase_rad) {
  return std::min(error_as_waves(grey_levels, phase_rad, 1.0),
                  error_as_waves(grey_levels, phase_rad, -1.0));
}

std::span<const Question<MeasuredFacts>> bench_questions() {
  return kBench;
}

}  // namespace ovws::examine
