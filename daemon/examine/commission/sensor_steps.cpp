/// Steps that make the sensor measure: exposure, reference, calibration, first closed loop, save.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "daemon/examine/commission/drawing.hpp"
#include "daemon/examine/commission/light.hpp"
#include "daemon/examine/commission/step.hpp"
#include "daemon/shared/lost_spots.hpp"

namespace ovws::commission {
namespace {

using nlohmann::json;

constexpr int kReferenceFrames = 100, kCalibrationFrames = 10;
constexpr double kTestMode_waves = 0.1;  ///< defocus that the first loop must remove
constexpr int kTestMode = 4;
constexpr double kOpen_s = 1.0, kClosed_s = 4.0;
constexpr double kJudged_s = 1.0;  ///< the newest frames of the closed loop
constexpr double kMuchLess = 0.2;  ///< of the test that may be left

/// Names the spots, with their places by the reference.
std::string named(Bench& bench, const std::vector<int>& spots) {
  const auto reference = bench.try_call("reference.get");
  return cli::placed_spots(spots, reference ? *reference : json());
}

/// Advice about lost spots.
std::string look_there() {
  return std::string(cli::kLookThere) + "; the step doctor judges the zeroth order.";
}

/// Warns of the lost spots, if any, after the verdict's other words.
void warn_of(Bench& bench, const std::vector<int>& lost, const char* what,
             examine::Finding& verdict) {
  if (lost.empty()) return;
  verdict.severity = Severity::warning;
  verdict.text += fmt::format(" {}: {}.", what, named(bench, lost));
  verdict.advice += (verdict.advice.empty() ? "" : " ") + look_there();
}

// Reference ---------------------------------------------------------------------------------------

Outcome run_reference(Bench& bench, Memory& memory) {
  const json config = bench.call("config.get");
  const json flatness = bench.call("flatness.get");
  const auto taken =
      bench.job("reference.take", {{"frames", kReferenceFrames}}, "averaging the spots");
  if (!taken) {
    const bool is_too_bright = taken.error().field == "camera.exposure_us";
    auto offers = other_first(memory, "brightness", "find the exposure again");
    return failed(taken.error(), "", is_too_bright ? std::move(offers) : std::vector<Offer>());
  }
  auto outcome =
      passed(fmt::format("Taken from {} frames: noise {:.4f} pixels, drift {:.4f} pixels.",
                         taken->at("frames").get<int>(), taken->at("noise_px").get<double>(),
                         taken->at("drift_px").get<double>()));
  if (!is_fixed_array(config) && flatness.at("measured") == false) {
    outcome.verdict.severity = Severity::warning;
    outcome.verdict.text +=
        " It contains the bench's own aberration, which the loop would keep: the flatness is not "
        "measured.";
    outcome.verdict.advice = "Measure the flatness first.";
    outcome.offers = {{"flatness", "measure the flatness first", {}, "flatness"}};
  }
  warn_of(bench, taken->at("lost_spots"), "Lost spots are left out", outcome.verdict);
  return outcome;
}

// Calibration -------------------------------------------------------------------------------------

Image<std::uint8_t> graph_of_factors(const json& modes) {
  Graph graph(0.0, double(modes.size()) + 1.0, 0.0, 1.5);
  for (const json& mode : modes) {
    if (!mode.at("factor").is_number()) continue;
    graph.bar(mode.at("j").get<double>(), 0.35, mode.at("factor").get<double>());
  }
  return graph.image();
}

Outcome run_calibration(Bench& bench, Memory&) {
  const auto made = bench.job("calibration.run", {{"frames", kCalibrationFrames}},
                              "showing each mode with both signs");
  if (!made) return failed(made.error());
  auto outcome =
      passed(fmt::format("{} modes are calibrated; condition number {:.1f}, drift {:.4f} pixels.",
                         made->at("modes").size(), made->at("condition_number").get<double>(),
                         made->at("drift_px").get<double>()));
  if (made->at("disagreement") == "none") {
    outcome.verdict.text += " The bench agrees with the model.";
  } else {
    outcome.verdict.severity = Severity::warning;
    outcome.verdict.advice = made->at("disagreement_reason").get<std::string>() + ".";
  }
  warn_of(bench, made->at("lost_spots"), "It lacks lost spots", outcome.verdict);
  outcome.picture = graph_of_factors(made->at("modes"));
  return outcome;
}

// First closed loop -------------------------------------------------------------------------------

struct LoopRun {
  std::vector<WatchedFrame> open, closed;
  json report;  ///< loop.get at the end
};

/// RMS that the closed loop leaves; none: no judged frame is valid.
std::optional<double> left_waves(std::span<const WatchedFrame> closed) {
  return median_rms_waves(newest(closed, kJudged_s));
}

/// Watches a second with the loop open and a known defocus, then closes it and waits until the
/// defocus is removed.
LoopRun watch_loop(Bench& bench, bool is_closed) {
  if (is_closed) bench.call("loop.open");
  const json test{{"modes", json::array({{{"j", kTestMode}, {"waves", kTestMode_waves}}})}};
  const auto hologram_id =
      bench.call("aberration.set", test).at("hologram_id").get<std::uint64_t>();
  LoopRun run;
  run.open = bench.frames(kOpen_s, [&](std::span<const WatchedFrame> frames) {
    return !frames.empty() && frames.back().hologram_id == hologram_id && frames.back().rms_waves;
  });
  std::erase_if(run.open,
                [&](const WatchedFrame& frame) { return frame.hologram_id != hologram_id; });
  const auto before = median_rms_waves(run.open);
  if (!before) return run;
  bench.call("loop.close");
  run.closed = bench.frames(kClosed_s, [&](std::span<const WatchedFrame> frames) {
    const auto after = left_waves(frames);
    return after && *after < kMuchLess * *before;
  });
  run.report = bench.call("loop.get");
  return run;
}

Image<std::uint8_t> graph_of_rms(const LoopRun& run) {
  std::vector<std::pair<double, double>> points;
  double most = 0.0;
  for (const auto* frames : {&run.open, &run.closed}) {
    for (const WatchedFrame& frame : *frames) {
      if (!frame.rms_waves) continue;
      points.emplace_back(double(points.size()), *frame.rms_waves);
      most = std::max(most, points.back().second);
    }
  }
  Graph graph(0.0, std::max<double>(1.0, double(points.size())), 0.0, 1.1 * most);
  graph.line(points);
  return graph.image();
}

/// Why no frame was valid: the spots that are lost, or else the daemon's reason.
Outcome no_valid_frame(Bench& bench) {
  const std::vector<int> lost = bench.lost_spots();
  if (!lost.empty()) {
    return failed("no frame was valid, and these spots are lost: " + named(bench, lost),
                  look_there());
  }
  const json invalid = bench.call("system.status").at("sensor").at("invalid");
  return failed(
      "no frame was valid" +
          (invalid.is_object() ? ": " + invalid.at("reason").get<std::string>() : std::string()),
      "Look at ovws status, and take the reference again.");
}

Outcome judge_loop(Bench& bench, const LoopRun& run) {
  const auto before = median_rms_waves(run.open);
  const auto after = left_waves(run.closed);
  if (!before) return no_valid_frame(bench);
  if (run.report.at("closed") == false) {
    const json& why = run.report.at("opened_because");
    return failed(
        "The loop opened by itself: " + (why.is_string() ? why.get<std::string>() : "no reason"),
        "Take a new reference, and run the calibration again.");
  }
  if (!after) return no_valid_frame(bench);
  const std::string figures = fmt::format(
      "A defocus of {:.2f} wave was shown: the RMS fell from {:.4f} to {:.4f} wave in "
      "{} steps.",
      kTestMode_waves, *before, *after, run.report.at("steps").get<int>());
  if (*after < kMuchLess * *before) return passed(figures);
  return failed(figures,
                "Less was removed than expected: take the reference again, then the calibration.");
}

Outcome run_loop(Bench& bench, Memory& memory) {
  const cli::Parts before =
      bench.parts({cli::Part::aberration, cli::Part::correction, cli::Part::loop});
  if (!memory.undo) memory.undo = {before, {}, "Loop, aberration and correction are as before."};
  cli::Borrow kept(bench.settings().daemon, before, bench.restoring());
  const bool was_closed = kept.before(cli::Part::loop).at("closed").get<bool>();
  bench.say("closing the loop on a known defocus");
  const LoopRun run = watch_loop(bench, was_closed);
  auto outcome = judge_loop(bench, run);
  outcome.picture = graph_of_rms(run);
  if (!kept.restore()) return outcome;  // the verdict will say it
  if (outcome.passed && was_closed) {
    outcome.verdict.text += " The loop is closed again, as before.";
  } else if (outcome.passed) {
    outcome.verdict.text += " The loop is open again.";
    outcome.offers = {{"close",
                       "close the loop, and leave it closed",
                       {{"loop.close", json::object()}},
                       {},
                       After::conclude}};
  }
  return outcome;
}

// Save --------------------------------------------------------------------------------------------

Outcome run_save(Bench& bench, Memory&) {
  const auto saved = bench.try_call("config.save");
  if (!saved) {
    return failed(saved.error(),
                  "Set state.directory in the configuration; the service has a folder of its own.");
  }
  const auto keys = saved->at("saved").get<std::vector<std::string>>();
  return passed(keys.empty() ? "All settings are those of the configuration file."
                             : fmt::format("Saved in {}: {}.", saved->at("path").get<std::string>(),
                                           fmt::join(keys, ", ")));
}

const std::array kSensorSteps{
    Step{"reference", "Reference", "Takes the wavefront from which coefficients count.",
         [](const Look& look) -> std::optional<bool> { return has_measured_reference(look); },
         run_reference, "reference.clear", "The reference is cleared.", true},
    Step{"calibration", "Calibration",
         "Shows each mode with both signs, and measures what it does to every spot.",
         [](const Look& look) -> std::optional<bool> {
           return is_true(look, "calibration.get", "in_force");
         },
         run_calibration, "calibration.clear", "The calibration is cleared.", false,
         Needs::holograms},
    Step{"loop", "First closed loop",
         "Shows a known defocus, closes the loop, and judges whether it is removed.",
         [](const Look& look) { return done_if(is_true(look, "loop.get", "closed")); }, run_loop,
         nullptr, nullptr, false, Needs::holograms},
    Step{"save", "Save", "Saves the settings in use for the next start of the daemon.",
         [](const Look&) { return std::optional<bool>(); }, run_save}};

}  // namespace

std::span<const Step> sensor_steps() {
  return kSensorSteps;
}

}  // namespace ovws::commission
