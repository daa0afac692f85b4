#include "proto/experiment.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "proto/limits.hpp"
#include "proto/names.hpp"
#include "proto/reader.hpp"
#include "proto/requests.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr int kObliqueAstigmatism = 3;
constexpr std::array<double, 3> kPaperWaves{0.5, 1.5, 2.0};  // unit amplitude

void read_distinct(ObjectReader& reader, const char* key, std::vector<double>& out,
                   std::size_t least, std::size_t most) {
  std::vector<double> given;
  reader.numbers(key, given, least, most, limits::kGainDb.min, limits::kGainDb.max);
  if (!reader.has(key)) return;
  std::vector<double> sorted = given;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
    reader.fault(key, "the same gain is given twice");
  }
  out = std::move(given);
}

void read_aberrations(ObjectReader& reader, GainSweep& sweep) {
  for (const double waves : kPaperWaves) {
    sweep.aberrations.push_back(
        {{kObliqueAstigmatism, waves / zernike_rms_factor(kObliqueAstigmatism)}});
  }
  const json* const given = reader.raw("aberrations");
  if (given == nullptr) return;
  if (!given->is_array() || given->empty() || given->size() > limits::kSweepAberrations) {
    return reader.fault("aberrations", "must be an array of 1 to " +
                                           std::to_string(limits::kSweepAberrations) +
                                           " objects, each as the params of aberration.set");
  }
  sweep.aberrations.clear();
  for (std::size_t k = 0; k < given->size(); ++k) {
    auto modes = ModesSet::decode((*given)[k]);
    if (!modes) {
      const std::string& inner = modes.error().field;
      return reader.fault(
          "aberrations[" + std::to_string(k) + "]" + (inner.empty() ? "" : ".") + inner,
          modes.error().reason);
    }
    sweep.aberrations.push_back(std::move(modes->modes));
  }
}

void read_arms(ObjectReader& reader, GainSweep& sweep) {
  std::vector<SweepArm> arms;
  reader.objects("arms", limits::kSweepArms, [&arms](ObjectReader& r, std::size_t) {
    SweepArm arm;
    int tracker = 0;
    r.require("charge");
    r.require("tracker");
    r.integer("charge", arm.charge, limits::kCharge.min, limits::kCharge.max);
    r.choice("tracker", tracker, sweep_tracker_names());
    arm.fixed_cell = std::size_t(tracker) == tracker_names().size();
    arm.tracker = arm.fixed_cell ? TrackerKind::centroid : TrackerKind(tracker);
    if (r.failed()) return;
    if (std::find(arms.begin(), arms.end(), arm) != arms.end()) r.fault("", "is given twice");
    arms.push_back(arm);
  });
  if (!reader.has("arms")) return;
  if (arms.empty()) reader.fault("arms", "must name one arm at least");
  sweep.arms = std::move(arms);
}

json modes_json(const std::vector<Mode>& modes) {
  json all = json::array();
  for (const Mode& mode : modes) all.push_back({{"j", mode.j}, {"waves", mode.waves}});
  return all;
}

}  // namespace

GainSweep::Cell GainSweep::cell(std::size_t number) const {
  const std::size_t row = number / arms.size();
  return {number % arms.size(), row / gains_db.size(), row % gains_db.size()};
}

const std::vector<std::string>& sweep_tracker_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = tracker_names();
    all.emplace_back("cell_centroid");
    return all;
  }();
  return names;
}

std::string sweep_tracker_name(const SweepArm& arm) {
  return arm.fixed_cell ? sweep_tracker_names().back() : std::string(tracker_name(arm.tracker));
}

Result<GainSweep> GainSweep::decode(const json& params) {
  GainSweep sweep;
  ObjectReader reader(params, "");
  reader.boolean("clamp", sweep.clamp);
  reader.boolean("anew", sweep.anew);
  read_distinct(reader, "gains_db", sweep.gains_db, 1, limits::kSweepGains);
  read_distinct(reader, "picture_gains_db", sweep.picture_gains_db, 0, limits::kSweepPictures);
  reader.integer("frames", sweep.frames, limits::kSweepFrames.min, limits::kSweepFrames.max);
  reader.number("reference_gain_db", sweep.reference_gain_db, limits::kGainDb.min,
                limits::kGainDb.max);
  reader.integer("reference_frames", sweep.reference_frames, limits::kSweepFrames.min,
                 limits::kSweepFrames.max);
  read_aberrations(reader, sweep);
  read_arms(reader, sweep);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return sweep;
}

json to_json(const SweepArm& arm) {
  return {{"charge", arm.charge}, {"tracker", sweep_tracker_name(arm)}};
}

json to_json(const GainSweep& sweep) {
  json arms = json::array(), aberrations = json::array();
  for (const SweepArm& arm : sweep.arms) arms.push_back(to_json(arm));
  for (const auto& modes : sweep.aberrations) {
    aberrations.push_back({{"modes", modes_json(modes)}, {"norm", "rms"}});
  }
  return {{"gains_db", sweep.gains_db},
          {"frames", sweep.frames},
          {"reference_gain_db", sweep.reference_gain_db},
          {"reference_frames", sweep.reference_frames},
          {"aberrations", std::move(aberrations)},
          {"arms", std::move(arms)},
          {"picture_gains_db", sweep.picture_gains_db}};
}

}  // namespace ovws
