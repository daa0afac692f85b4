/// Steps that measure the SLM and its place on the camera.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "daemon/examine/commission/drawing.hpp"
#include "daemon/examine/commission/step.hpp"
#include "daemon/examine/in_use.hpp"

namespace ovws::commission {
namespace {

using nlohmann::json;

constexpr int kLutLevels = 17, kSettleRepetitions = 10;
constexpr double kNoticeableScale = 0.03;  ///< relative to the configured one
constexpr double kGoodFlatness_waves = 0.02;

// Registration ------------------------------------------------------------------------------------

/// The camera's image with a mark at the base spot; empty: no image came.
Image<std::uint8_t> picture_of_base(Bench& bench, const json& map) try {
  auto grey = grey_of(bench.image());
  const json roi = bench.call("camera.get").at("settings").at("roi");
  mark(grey, map.at("base_px").at(0).get<double>() - roi.at("x").get<double>(),
       map.at("base_px").at(1).get<double>() - roi.at("y").get<double>());
  return grey;
} catch (const StepFailed&) {
  return {};
}

/// Finds a fixed array of lenslets in the image.
Outcome run_array(Bench& bench) {
  const auto map = bench.job("registration.run", json::object(), "looking for the array");
  if (!map) {
    return failed(map.error(),
                  "Light the whole array, and compare array.pitch_um, sensor.grid and optics of "
                  "the configuration with it.");
  }
  const json& array = map->at("array");
  auto outcome = passed(
      fmt::format("{} lenslets are lit, rotated by {:.2f} degrees and magnified {:.4f} times; the "
                  "spots are where the lattice predicts them to within {:.3f} pixels RMS.",
                  array.at("lit").get<int>(), array.at("lenslets").at("rotation_deg").get<double>(),
                  array.at("magnification").get<double>(), map->at("residual_px").get<double>()));
  outcome.picture = picture_of_base(bench, *map);
  return outcome;
}

Outcome run_registration(Bench& bench, Memory& memory) {
  const json config = bench.call("config.get");
  if (is_fixed_array(config)) return run_array(bench);
  const auto map = bench.job("registration.run", json::object(), "moving one spot about");
  if (!map) {
    return failed(map.error(),
                  "If there is light, the SLM's phase may fall with the grey level: measure "
                  "the look-up table first.",
                  other_first(memory, "lut", "measure the look-up table first"));
  }
  const double ratio =
      map->at("scale_px_per_cycle").get<double>() / examine::configured_px_per_cycle(config);
  const bool is_mirrored = map->at("mirrored").get<bool>();
  auto outcome = passed(
      fmt::format("The camera sees the SLM rotated by {:.2f} degrees, {}; one spot moves as "
                  "predicted to within {:.3f} pixels.",
                  map->at("rotation_deg").get<double>(), is_mirrored ? "mirrored" : "not mirrored",
                  map->at("residual_px").get<double>()));
  if (std::abs(ratio - 1.0) > kNoticeableScale) {
    outcome.verdict.severity = Severity::note;
    outcome.verdict.advice = fmt::format(
        "The scale is {:.3f} times the configured one, and the measured one is used: "
        "correct optics.focal_length_mm, or a pitch, in the configuration.",
        ratio);
  }
  outcome.picture = picture_of_base(bench, *map);
  return outcome;
}

// Look-up table -----------------------------------------------------------------------------------

Image<std::uint8_t> graph_of_phase(const json& lut) {
  const auto phase = lut.at("phase_rad").get<std::vector<double>>();
  const auto [least, most] = std::ranges::minmax_element(phase);
  Graph graph(0.0, 255.0, *least, *most);
  std::vector<std::pair<double, double>> points;
  for (std::size_t k = 0; k < phase.size(); ++k) points.emplace_back(double(k), phase[k]);
  graph.line(points);
  return graph.image();
}

Outcome run_lut(Bench& bench, Memory& memory) {
  const auto lut = bench.job("lut.run", {{"levels", kLutLevels}},
                             "showing grey levels in two patches that interfere");
  if (!lut) {
    return failed(lut.error(),
                  "A wavelength, pitch or focal length that is wrong in the configuration has this "
                  "effect, and so has a base spot outside the camera's region.",
                  other_first(memory, "registration", "run the registration first"));
  }
  auto outcome = passed(
      fmt::format("The phase {} with the grey level, is {:.2f} pi deep, and was measured to within "
                  "{:.1f} mrad.",
                  lut->at("falls") == true ? "falls" : "rises",
                  lut->at("depth_rad").get<double>() / std::numbers::pi,
                  1e3 * lut->at("residual_rad").get<double>()));
  if (lut->at("reaches_2pi") == false) {
    outcome.verdict.severity = Severity::warning;
    outcome.verdict.advice = lut->at("reason").get<std::string>() +
                             ". Use the SLM's setting for this wavelength, if it has one.";
  }
  outcome.picture = graph_of_phase(*lut);
  return outcome;
}

// Settle time -------------------------------------------------------------------------------------

Outcome run_settle(Bench& bench, Memory& memory) {
  const json before_ms = bench.call("config.get").at("slm").at("settle_ms");
  if (!memory.undo) {
    memory.undo = {
        {},
        {{"slm.set", {{"settle_ms", before_ms}}}},
        fmt::format("slm.settle_ms is {:.1f} again, as before.", before_ms.get<double>())};
  }
  const auto time =
      bench.job("slm.settle", {{"repetitions", kSettleRepetitions}}, "moving one spot to and fro");
  if (!time) return failed(time.error());
  bench.call("slm.set", {{"settle_ms", time->at("proposed_settle_ms")}});
  auto outcome = passed(
      fmt::format("The SLM settles in {:.1f} ms; slm.settle_ms is now {:.1f}, it was {:.1f}.",
                  time->at("max_ms").get<double>(), time->at("proposed_settle_ms").get<double>(),
                  before_ms.get<double>()));
  if (time->at("long_enough") == false) {
    outcome.verdict.severity = Severity::warning;
    outcome.verdict.advice =
        "The previous steps waited too short a time: run registration and look-up table again.";
    outcome.offers = {{"lut", "measure the look-up table again", {}, "lut"},
                      {"registration", "run the registration again", {}, "registration"}};
  }
  return outcome;
}

// Aberration and correction -----------------------------------------------------------------------

bool is_sequence(const json& aberration) {
  return !aberration.value("patterns", json::array()).empty();
}

Outcome run_clear(Bench& bench, Memory& memory) {
  // A DMD's sequence is not a part that can be put back: the parts are those after its end.
  if (is_sequence(bench.call("aberration.get"))) bench.call("aberration.clear");
  const cli::Parts before = bench.parts({cli::Part::aberration, cli::Part::correction});
  if (!memory.undo) memory.undo = {before, {}, "Aberration and correction are as before."};
  if (bench.call("loop.get").at("closed") == true) bench.call("loop.open");
  bench.call("aberration.clear");
  bench.call("correction.clear");
  return passed("The hologram contains no aberration and no correction.");
}

bool nothing_is_introduced(const Look& look) {
  const json aberration = look.at("aberration.get");
  return aberration.at("modes").empty() && !is_sequence(aberration) &&
         look.at("correction.get").at("modes").empty();
}

// Flatness ----------------------------------------------------------------------------------------

Image<std::uint8_t> graph_of_modes(const json& modes) {
  double most = 1e-3;
  for (const json& mode : modes) most = std::max(most, std::abs(mode.at("waves").get<double>()));
  Graph graph(0.0, double(modes.size()) + 3.0, -1.1 * most, 1.1 * most);
  for (const json& mode : modes) {
    graph.bar(mode.at("j").get<double>(), 0.35, mode.at("waves").get<double>());
  }
  return graph.image();
}

Outcome run_flatness(Bench& bench, Memory& memory) {
  const auto flatness =
      bench.job("flatness.run", json::object(), "moving one bright spot's aperture over the pupil");
  if (!flatness) {
    return failed(flatness.error(), "",
                  other_first(memory, "registration", "run the registration again"));
  }
  const double rms = flatness->at("rms_waves").get<double>();
  auto outcome = passed(
      fmt::format("SLM and optics deviate by {:.3f} wave RMS, which every hologram now corrects; "
                  "the last of {} scans changed {:.4f} wave.",
                  rms, flatness->at("iterations").get<int>(),
                  flatness->at("residual_rms_waves").get<double>()));
  if (rms < kGoodFlatness_waves) outcome.verdict.text += " The bench was flat already.";
  outcome.picture = graph_of_modes(flatness->at("modes"));
  return outcome;
}

const std::array kSlmSteps{
    Step{
        "registration", "Registration",
        "Measures how the camera is turned, mirrored and scaled relative to the SLM, by moving one "
        "spot; or finds a fixed array of lenslets in the image.",
        [](const Look& look) -> std::optional<bool> {
          return is_true(look, "registration.get", "registered");
        },
        run_registration, "registration.clear", "The registration is cleared.", true},
    Step{"lut", "Look-up table",
         "Measures which grey level of the SLM gives which phase, by the interference of two "
         "patches.",
         [](const Look& look) -> std::optional<bool> {
           return look.at("lut.get").at("source") != "linear";
         },
         run_lut, "lut.clear", "The measured look-up table is cleared.", false, Needs::phase},
    Step{"settle", "Settle time",
         "Measures how long the SLM needs to settle after a change, and waits that long from then "
         "on.",
         // A calibration is measured after it, and waits that long after each poke.
         [](const Look& look) { return done_if(is_true(look, "calibration.get", "in_force")); },
         run_settle, nullptr, nullptr, false, Needs::holograms},
    Step{"clear", "Aberration and correction",
         "Removes what was introduced on purpose, so that the bench itself is measured.",
         [](const Look& look) -> std::optional<bool> { return nothing_is_introduced(look); },
         run_clear, nullptr, nullptr, false, Needs::holograms},
    Step{"flatness", "Flatness",
         "Measures the aberration of SLM and optics, and corrects it in every hologram.",
         [](const Look& look) -> std::optional<bool> {
           return is_true(look, "flatness.get", "measured");
         },
         run_flatness, "flatness.clear", "The measured flatness is cleared.", false,
         Needs::holograms}};

}  // namespace

std::span<const Step> slm_steps() {
  return kSlmSteps;
}

}  // namespace ovws::commission
