#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/examine/check/judge.hpp"
#include "daemon/examine/check/measured.hpp"
#include "daemon/examine/in_use.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"
#include "daemon/shared/lost_spots.hpp"
#include "proto/limits.hpp"

namespace ovws::examine {
namespace {

using nlohmann::json;

constexpr const char* kPredictor =
    "ovws call loop.identify --wait && ovws loop close law=predictor";

double settle_used_ms(const Measured& measured) {
  return measured.config.at("slm").at("settle_ms").get<double>();
}

/// The worst poke that was read, or null.
const Poke* worst_poke(const Response& response) {
  const Poke* worst = nullptr;
  for (const Poke& poke : response.pokes) {
    if (!poke.read) continue;
    if (worst == nullptr ||
        error_waves(poke, response.modes_j) > error_waves(*worst, response.modes_j)) {
      worst = &poke;
    }
  }
  return worst;
}

/// The modes that were not read, and why; empty: all were.
std::string unread_modes(const Response& response) {
  std::string names;
  int settled = 0, valid = 0;
  for (const Poke& poke : response.pokes) {
    if (poke.read) continue;
    names += (names.empty() ? "" : ", ") + zernike_name(poke.j);
    settled += poke.settled;
    valid += poke.valid;
  }
  if (names.empty()) return names;
  return fmt::format("{}: while they are shown, {} of {} settled frames are valid{}{}", names,
                     valid, settled, response.reason.empty() ? "" : ": ", response.reason);
}

/// Why spots are lost, by the configuration; empty: the configuration gives no reason.
std::string layout_reason(const json& in_use) {
  const auto config = layout_in_use(in_use);
  if (!config) return {};
  const auto lattice = make_lattice(config->sensor, config->slm.geometry);
  if (!lattice) return {};
  const auto dark = check_zeroth_order(spot_bench(*config, *lattice));
  return dark ? std::string() : text_of(dark.error());
}

/// Where spots are lost, in the words of a report; empty: nowhere.
std::string lost_spots(const Measured& measured) {
  const json& calibration = measured.calibration;
  const auto calibrated = calibration.value("lost_spots", json());
  const std::pair<const char*, std::vector<int>> all[] = {
      {"in the reference", cli::lost_in_reference(measured.reference)},
      {"in the calibration",
       calibrated.is_array() ? calibrated.get<std::vector<int>>() : std::vector<int>()},
      {"in more than a tenth of the frames", measured.open.spots.lost(0.9)},
      {"in most frames while modes are shown", measured.response.spots.lost(0.5)}};
  std::string text;
  for (const auto& [where, spots] : all) {
    if (spots.empty()) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", where,
                        cli::placed_spots(spots, measured.reference));
  }
  return text;
}

std::string better_readings(const Measured& measured) {
  if (measured.sensor.at("tracker") != "fit") return "ovws call sensor.set tracker=fit";
  if (!measured.registration.at("registered").get<bool>())
    return "ovws call registration.run --wait";
  return "ovws call calibration.run --wait";
}

/// Error of the first frames after a change, waves; NaN: not known. The frames of the first poke
/// are watched for longest, so that it shows a slow SLM best.
double first_error(const Response& response) {
  std::vector<double> errors;
  for (const Poke& poke : response.pokes) {
    if (poke.read) errors.push_back(poke.first_error_waves);
  }
  if (errors.empty()) return study::kUnknown;
  const double first_watched = errors.front();
  std::ranges::sort(errors);
  return std::max(errors[errors.size() / 2], first_watched);
}

/// A finding for which too few frames were valid.
Finding unmeasured(Finding found) {
  found.severity = Severity::note;
  found.text = fmt::format("not measured: fewer than {} frames are valid", kMinFrames);
  return found;
}

double mean_saturated(const Record& record) {
  double sum = 0.0;
  for (const Frame& frame : record.frames) sum += frame.saturated;
  return record.frames.empty() ? 0.0 : sum / double(record.frames.size());
}

Finding judge_response(const MeasuredFacts& facts) {
  constexpr double kGood = 0.002, kWarning = 0.005, kBad = 0.02;
  const Response& response = facts.measured.response;
  Finding found;
  found.limit = fmt::format("error at most {} wave; bad above {} wave", kGood, kBad);
  found.fix = better_readings(facts.measured);
  const Poke* const poke = worst_poke(response);
  const std::string unread = unread_modes(response);
  if (poke == nullptr) {
    found.severity = Severity::bad;
    found.text = "no mode could be read: " + unread;
    found.fix = "ovws doctor";
    return found;
  }
  const double error = error_waves(*poke, response.modes_j);
  const study::Mean slope = slope_of(*poke, response.modes_j);
  found.cost_waves = error;
  found.severity = severity_of(error, kGood, kWarning, kBad);
  found.text = fmt::format(
      "the worst mode, {}, is read with a slope of {:.4f} ± {:.4f} and a cross-talk of {:.4f}: an "
      "error of {:.4f} wave",
      zernike_name(poke->j), slope.value, slope.standard_error,
      crosstalk_of(*poke, response.modes_j), error);
  if (unread.empty()) return found;
  found.severity = Severity::bad;
  found.text += "; not readable: " + unread;
  return found;
}

Finding judge_noise(const MeasuredFacts& facts) {
  constexpr double kRatio = 1.5, kBadRatio = 10.0, kMost = 0.01;
  const Stability& open = facts.open;
  Finding found;
  found.limit =
      fmt::format("at most {} wave, and at most {} times what the frames state", kMost, kRatio);
  if (!open.usable) return unmeasured(found);
  found.cost_waves = open.noise;
  found.text =
      fmt::format("{:.5f} wave (root sum square over {} modes)", open.noise, open.modes.size());
  found.fix = "ovws call camera.auto_exposure --wait";
  found.severity = severity_of(open.noise, kMost, kMost, 10.0 * kMost);
  if (std::isnan(open.stated) || open.stated <= 0.0) {
    found.text += "; the frames state no standard errors";
    return found;
  }
  const double ratio = open.noise / open.stated;
  found.text +=
      fmt::format(", {:.2f} times the {:.5f} wave that the frames state", ratio, open.stated);
  found.severity = std::max(found.severity, severity_of(ratio, kRatio, 2.0 * kRatio, kBadRatio));
  return found;
}

Finding judge_motion(const MeasuredFacts& facts) {
  constexpr double kGood = 0.005, kWarning = 0.01, kBad = 0.05;
  const Stability& open = facts.open;
  Finding found;
  found.limit = fmt::format("at most {} wave RMS with tilts; bad above {} wave", kGood, kBad);
  if (!open.usable) return unmeasured(found);
  found.cost_waves = open.motion;
  found.severity = severity_of(open.motion, kGood, kWarning, kBad);
  found.text = fmt::format("the wavefront moves by {:.4f} wave RMS", open.motion);
  if (found.severity == Severity::good) return found;
  found.text += fmt::format(", most in {}", zernike_name(open.strongest_j));
  if (open.frequency_hz > 0.0) {
    found.text += fmt::format(
        ", as a vibration of {:.1f} Hz: look for its source, and for a mount that carries it",
        open.frequency_hz);
  } else {
    found.text += ", without a frequency of its own: cover the beam's path against moving air";
  }
  found.fix = kPredictor;
  return found;
}

Finding judge_drift(const MeasuredFacts& facts) {
  constexpr double kGood = 0.005, kWarning = 0.02, kBad = 0.1;
  Finding found;
  found.limit = fmt::format("at most {} wave; bad above {} wave", kGood, kBad);
  if (!facts.open.usable) return unmeasured(found);
  found.cost_waves = facts.open.drift;
  found.severity = severity_of(facts.open.drift, kGood, kWarning, kBad);
  found.text = fmt::format("{:.4f} wave in {:.0f} s (straight line, all modes)", facts.open.drift,
                           facts.measured.open.seconds());
  found.fix = "ovws loop close";
  // A slow part of a motion looks like a drift.
  if (facts.open.motion > facts.open.drift)
    found.cause = found.severity == Severity::good ? "" : "motion";
  return found;
}

Finding judge_loop(const MeasuredFacts& facts) {
  constexpr double kGood = 0.005, kWarning = 0.02;
  const LoopResult& loop = facts.measured.loop;
  Finding found;
  found.limit = fmt::format("leaves at most {} wave RMS without tilts", kGood);
  if (loop.loop.is_null()) {
    found.severity = loop.failed ? Severity::bad : Severity::note;
    found.text = (loop.failed ? "it opened by itself: " : "not measured: ") + loop.reason;
    found.fix = loop.failed ? "ovws doctor" : "";
    return found;
  }
  const double rms = rms_waves(loop.record);
  if (std::isnan(rms)) {
    found.severity = Severity::bad;
    found.text = "no frame is valid while it is closed";
    found.fix = "ovws status";
    return found;
  }
  const json& step = loop.loop.at("step");
  const double step_ms = step.at("p50_ms").get<double>();
  found.cost_waves = rms;
  found.severity = severity_of(rms, kGood, kWarning, 1.0);
  found.text = fmt::format(
      "leaves {:.4f} wave RMS without tilts at {:.1f} steps/s, with a delay of {:.0f} ms", rms,
      step_ms > 0.0 ? 1e3 / step_ms : 0.0, step.at("delay_ms").get<double>());
  found.fix = kPredictor;
  return found;
}

Finding judge_frames(const MeasuredFacts& facts) {
  constexpr double kNote = 0.001, kWarning = 0.01, kBad = 0.1;
  const Record& open = facts.measured.open;
  Finding found;
  found.limit = fmt::format("at least {:.1f} % valid; bad below {:.0f} %", 100.0 * (1.0 - kNote),
                            100.0 * (1.0 - kBad));
  const auto valid = std::ranges::count_if(open.frames, [](const Frame& one) { return one.valid; });
  const double invalid =
      open.frames.empty() ? 1.0 : 1.0 - double(valid) / double(open.frames.size());
  found.text = fmt::format(
      "without a mode shown, {} of {} settled frames are valid, at {:.1f} "
      "frames/s",
      valid, open.frames.size(), facts.open.frame_rate_hz);
  found.severity = facts.open.usable ? severity_of(invalid, kNote, kWarning, kBad) : Severity::bad;
  found.fix = "ovws status";
  return found;
}

Finding judge_spots(const MeasuredFacts& facts) {
  constexpr double kBlinding = 0.5;  // share of saturated spots that loses others
  Finding found;
  found.limit = "every spot is found, and is part of the reference and of the calibration";
  const std::string lost = lost_spots(facts.measured);
  found.text = lost.empty() ? "none is lost" : "lost " + lost;
  if (lost.empty()) return found;
  found.severity = Severity::warning;
  if (mean_saturated(facts.measured.open) > kBlinding) {
    found.cause = "saturation";
    return found;
  }
  const std::string reason = layout_reason(facts.measured.config);
  found.text += reason.empty() ? std::string(". ") + cli::kLookThere : "; " + reason;
  found.fix = reason.empty() ? "ovws snapshot -o lost" : "ovws doctor";
  return found;
}

Finding judge_saturation(const MeasuredFacts& facts) {
  const double share = mean_saturated(facts.measured.open);
  Finding found;
  found.limit =
      fmt::format("no spot; bad above {:.0f} % of the spots", 100.0 * limits::kMaxSaturatedSpots);
  found.text = fmt::format("{:.1f} % of the spots have a pixel at full scale", 100.0 * share);
  if (share == 0.0) found.text = "no spot has a pixel at full scale";
  found.severity = severity_of(share, 0.0, 0.0, limits::kMaxSaturatedSpots);
  found.fix = "ovws call camera.auto_exposure --wait && ovws reference 100";
  return found;
}

Finding judge_settle(const MeasuredFacts& facts) {
  constexpr double kGood = 0.02;  // the first frames after a jump are measured less exactly
  constexpr double kTooLong = 2.0, kTooLongMs = 20.0;
  const Measured& measured = facts.measured;
  const double used = settle_used_ms(measured), first = first_error(measured.response);
  Finding found;
  found.limit = fmt::format(
      "first frame after a change within {} wave of the later ones; no longer than {:g} times what "
      "is needed",
      kGood, kTooLong);
  found.text = fmt::format("{:g} ms are used", used);
  if (!std::isnan(first)) {
    found.text += fmt::format("; the first frame after a change is off by {:.4f} wave", first);
  }
  double proposed = 0.0;
  bool short_by_job = false;
  if (measured.settle.result.is_object()) {
    proposed = measured.settle.result.at("proposed_settle_ms").get<double>();
    short_by_job = !measured.settle.result.at("long_enough").get<bool>();
    found.text += short_by_job
                      ? fmt::format("; measured: {:g} ms are needed", proposed)
                      : fmt::format(
                            "; long enough: a change takes {:.1f} ms at most; with the usual "
                            "margin: {:g} ms",
                            measured.settle.result.at("max_ms").get<double>(), proposed);
  } else {
    found.text += "; not measured: " + measured.settle.reason;
    if (std::isnan(first)) found.severity = Severity::note;
  }
  // A wavefront that moves changes between two frames, too.
  const bool first_is_off = first > std::hypot(kGood, 3.0 * facts.open.motion);
  if (short_by_job || first_is_off) {
    found.severity = first_is_off ? Severity::bad : Severity::warning;
    if (first_is_off) found.cost_waves = first;
    found.fix = short_by_job ? fmt::format("ovws call slm.set settle_ms={:g}", proposed)
                             : "ovws call slm.settle watch_ms=1000 --wait";
  } else if (proposed > 0.0 && used > kTooLong * proposed + kTooLongMs) {
    found.severity = Severity::note;
    found.text += ": the loop is slower than necessary";
    found.fix = fmt::format("ovws call slm.set settle_ms={:g}", proposed);
  }
  return found;
}

Finding judge_losses(const MeasuredFacts& facts) {
  constexpr double kNote = 0.005, kWarning = 0.02, kBad = 0.1;
  constexpr std::array<const char*, 6> kNames{"frames_lost",         "frames_incomplete",
                                              "frames_dropped",      "frames_late",
                                              "frames_out_of_order", "messages_dropped"};
  Finding found;
  found.limit =
      fmt::format("at most {:g} %; warning above {:g} %", 100.0 * kNote, 100.0 * kWarning);
  const json before = facts.measured.status.at("counters"), &after = facts.measured.counters_after;
  std::int64_t lost = 0;
  for (const char* const name : kNames) {
    const std::int64_t rise =
        after.value(name, std::int64_t(0)) - before.value(name, std::int64_t(0));
    if (rise > 0) found.text += fmt::format("{}{} {}", found.text.empty() ? "" : ", ", name, rise);
    lost += std::max<std::int64_t>(0, rise);
  }
  const std::int64_t grabbed = after.value("frames_grabbed", std::int64_t(0)) -
                               before.value("frames_grabbed", std::int64_t(0));
  found.text = fmt::format("{} of {} frames", found.text.empty() ? "none" : found.text, grabbed);
  found.severity =
      severity_of(grabbed > 0 ? double(lost) / double(grabbed) : 1.0, kNote, kWarning, kBad);
  found.fix = "ovws doctor";
  return found;
}

constexpr std::array<Question<MeasuredFacts>, 10> kMeasurement{{
    {"response", judge_response, kNothing, kAll, "Response to 0.1 wave of each mode"},
    {"noise", judge_noise, kNothing, kAll, "Noise of a single frame"},
    {"motion", judge_motion, kNothing, kAll, "Vibration and turbulence"},
    {"drift", judge_drift, kNothing, kAll, "Drift over the record"},
    {"loop", judge_loop, kNothing, kAll, "Closed loop"},
    {"frames", judge_frames, kNothing, kAll, "Valid frames"},
    {"spots", judge_spots, kNothing, kAll, "Lost spots"},
    {"saturation", judge_saturation, kNothing, kAll, "Saturation"},
    {"settle", judge_settle, kNothing, kAll, "Settle time"},
    {"losses", judge_losses, kNothing, kAll, "Lost and late frames"},
}};

}  // namespace

std::span<const Question<MeasuredFacts>> measurement_questions() {
  return kMeasurement;
}

}  // namespace ovws::examine
