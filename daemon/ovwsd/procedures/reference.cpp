#include "daemon/ovwsd/procedures/measurements.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>

#include "daemon/ovwsd/sensor/reference_spots.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {
namespace {

/// A light source whose reference is taken.
struct Source {
  std::string beam;  ///< empty: the main one
  SpotAverage average;
};

/// The sources whose reference is taken, in the order of TakenReference.
std::vector<Source> sources_of(const TakenReference& taken, const std::vector<BeamShown>& beams) {
  std::vector<Source> sources;
  if (taken.only.empty() || taken.only == kMainBeam) sources.push_back({"", taken.average});
  for (std::size_t k = 0; k < beams.size(); ++k) {
    if (taken.only.empty() || taken.only == beams[k].name) {
      sources.push_back({beams[k].name, taken.beams[k]});
    }
  }
  return sources;
}

void warn(Bench& bench, const std::string& beam, const std::string& text, nlohmann::json data) {
  if (!beam.empty()) data["beam"] = beam;
  bench.warn("reference", (beam.empty() ? "" : "of the source " + beam + ", ") + text,
             std::move(data));
}

void warn_of_saturated(Bench& bench, const Source& of) {
  const std::vector<int> saturated = saturated_spots(of.average);
  if (saturated.empty()) return;
  warn(
      bench, of.beam,
      fmt::format("spots {} are saturated in some frames of the reference: for a better one, lower "
                  "the exposure or the gain and take it again",
                  listed_spots(saturated)),
      {{"saturated_spots", saturated}});
}

void warn_of_lost(Bench& bench, const std::string& beam, const ReferenceSpots& spots) {
  if (spots.lost.empty()) return;
  std::string text = fmt::format(
      "the reference does not use spots {}, which were found in fewer than half of its frames",
      listed_spots(spots.lost));
  if (!spots.weak_modes_j.empty()) {
    text += fmt::format("; without them the modes j = {} are noisier",
                        listed_spots(spots.weak_modes_j));
  }
  warn(bench, beam, text, {{"lost_spots", spots.lost}, {"weak_modes", spots.weak_modes_j}});
}

/// A reference taken under an introduced aberration is valid, but rarely intended.
void warn_of_introduced(Bench& bench, double rms_waves) {
  if (rms_waves == 0.0) return;
  bench.warn("reference",
             fmt::format("the reference contains the introduced aberration of {:.4f} wave RMS: "
                         "coefficients are relative to it, and the closed loop does not correct "
                         "it; for a reference without it call aberration.clear, then "
                         "reference.take",
                         rms_waves),
             {{"introduced_rms_waves", rms_waves}});
}

}  // namespace

Result<void> can_take_reference(const SensorSnapshot& sensor, const ReferenceTake& take) {
  if (auto shown = check_shows_one_sensor(sensor); !shown) return shown;
  auto found = check_array_found(sensor.sensor, sensor.registration.has_value());
  if (!found) return found;
  const auto is_named = [&](const BeamShown& one) { return one.name == take.beam; };
  if (!take.beam.empty() && take.beam != kMainBeam &&
      std::none_of(sensor.beams.begin(), sensor.beams.end(), is_named)) {
    return fail(Errc::invalid, "beam",
                fmt::format("there is no source \"{}\": use main or a name of `beams` in the "
                            "configuration",
                            take.beam));
  }
  const double introduced = rms_waves(sensor.aberration);
  if (take.allow_aberration || introduced == 0.0) return {};
  return fail(
      Errc::refused, "allow_aberration",
      fmt::format(
          "the SLM shows an introduced aberration of {:.4f} wave RMS, which would become part "
          "of the reference: clear it first (aberration.clear), or set \"allow_aberration\": true",
          introduced));
}

Result<nlohmann::json> take_reference(Bench& bench, const ReferenceTake& take, Bench::Step step) {
  const SensorView sensor = bench.sensor();
  if (auto can = can_take_reference(*sensor, take); !can) return fail(can.error());
  auto taken = bench.reference(take.frames, take.beam);
  if (!taken) return fail(taken.error());
  const std::vector<Source> sources = sources_of(*taken, sensor->beams);
  const auto spots = std::make_shared<std::vector<ReferenceSpots>>();
  auto change = use_reference(sensor->sensor_epoch, std::move(*taken), spots);
  if (auto used = bench.use(std::move(change), step); !used) return fail(used.error());
  const double introduced = rms_waves(sensor->aberration);
  for (std::size_t k = 0; k < sources.size(); ++k) {
    warn_of_saturated(bench, sources[k]);
    warn_of_lost(bench, sources[k].beam, spots->at(k));
  }
  warn_of_introduced(bench, introduced);
  const SpotAverage& average = sources.front().average;
  const ReferenceSpots& first = spots->front();
  return nlohmann::json{
      {"frames", average.frames},         {"saturated_spots", saturated_spots(average)},
      {"lost_spots", first.lost},         {"weak_spots", first.weak},
      {"weak_modes", first.weak_modes_j}, {"introduced_rms_waves", introduced},
      {"drift_px", average.drift_px},     {"scatter_px", average.scatter_px},
      {"noise_px", average.noise_px}};
}

}  // namespace ovws
