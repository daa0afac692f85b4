#include "daemon/web/bench_view.hpp"

#include "config/config.hpp"
#include "core/optics/zernike.hpp"
#include "core/tracking/spot.hpp"
#include "core/tracking/spot_geometry.hpp"
#include "daemon/examine/in_use.hpp"
#include "proto/json_text.hpp"
#include "proto/limits.hpp"
#include "proto/names.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

/// Limits the redraw rate: a closed loop makes up to ten holograms per second.
constexpr std::chrono::milliseconds kDrawPeriod{500};
constexpr std::chrono::seconds kSeldom{30};

/// Radius of the bright ring (vortex) or of the bright spot (charge 0), camera pixels.
double ring_px(const Config& config) {
  const SpotGeometry shape = spot_geometry(config.sensor.charge);
  const double lambdas = config.sensor.charge == 0 ? shape.ring_outer : shape.ring;
  return lambdas * lambda_d_px(config.optics, config.slm.geometry, config.sensor);
}

json sensor_of(const json& sensor, const json& in_use, const json& registration) {
  json view = sensor;
  view["mode_names"] = json::array();
  for (const json& j : sensor.at("modes_j")) {
    const ZernikeIndex index = zernike_index(j.get<int>());
    view["mode_names"].push_back(
        {{"j", j}, {"n", index.n}, {"m", index.m}, {"name", zernike_name(j.get<int>())}});
  }
  auto config = parse_config(json_text(in_use));
  for (const char* key : {"ring_px", "pupil_mm", "lambda_pupil_px"}) view[key] = nullptr;
  if (!config) return view;
  examine::use_registration(*config, registration);
  const SlmGeometry& slm = config->slm.geometry;
  view["ring_px"] = ring_px(*config);
  view["pupil_mm"] = config->sensor.pupil_diameter_px * slm.pitch_um * 1e-3;
  // lambda/D of the whole pupil: the shift by a phase slope of one cycle over the pupil.
  view["lambda_pupil_px"] =
      camera_px_per_cycle(config->optics, slm) / config->sensor.pupil_diameter_px;
  return view;
}

/// Ranges that the daemon accepts, as JSON; a device may have smaller ranges.
json limits_of_wire() {
  const auto range = [](const auto& limits) {
    return json{{"min", limits.min}, {"max", limits.max}};
  };
  json trackers = json::array();
  for (const std::string_view name : all_tracker_names()) {
    if (name != "lg_contour") trackers.push_back(name);  // only for offline use
  }
  return {{"mode_waves", range(limits::kModeWaves)},
          {"charge", range(limits::kCharge)},
          {"loop_gain", range(limits::kLoopGain)},
          {"reference_frames", range(limits::kReferenceFrames)},
          {"trackers", trackers},
          {"patterns", kShowablePatterns()}};
}

/// Without parts that the page does not show, to keep the message small.
json without(json report, std::initializer_list<const char*> keys) {
  for (const char* key : keys) report.erase(key);
  return report;
}

}  // namespace

json BenchView::hologram_of(const HologramSources& sources) {
  const auto now = Clock::now();
  const bool due = sources != drawn_ || !hologram();  // a file that was missing may be there now
  if (due && now - drawn_at_ > kDrawPeriod) {
    drawn_ = sources;
    drawn_at_ = now;
    auto picture = draw_hologram(sources);
    hologram_.set(picture ? *picture : nullptr);
    if (!picture) return {{"hologram_id", nullptr}, {"reason", picture.error().reason}};
  }
  const HologramImagePtr shown = hologram();
  if (!shown) return last_.value("hologram", json{{"hologram_id", nullptr}, {"reason", nullptr}});
  return {{"hologram_id", shown->hologram_id}, {"crc32", shown->crc32}, {"reason", nullptr}};
}

const json& BenchView::seldom(Seldom& kept, const char* method, std::int64_t jobs) {
  if (jobs == kept.jobs && Clock::now() - kept.at < kSeldom) return kept.answer;
  const auto known = cli::call(common_, method, json::object());
  if (!known) return kept.answer;
  kept = {without(*known, {"origin", "singular_values_px_per_wave"}), jobs, Clock::now()};
  return kept.answer;
}

std::optional<json> BenchView::look(std::int64_t jobs) {
  const auto answers =
      cli::call_all(common_, {"config.get", "camera.get", "sensor.get", "aberration.get",
                              "correction.get", "loop.get", "reference.get", "lut.get",
                              "flatness.get", "registration.get", "loop.model", "system.status"});
  if (!answers) return std::nullopt;
  const std::vector<json>& a = *answers;
  json view{{"schema", "ovws.web.bench/1"},
            {"camera", a[1]},
            {"sensor", sensor_of(a[2], a[0], a[9])},
            {"optics", a[0]["optics"]},
            {"aberration", a[3]},
            {"correction", a[4]},
            {"loop", a[5]},
            {"reference", without(a[6], {"positions_px", "standard_error_px", "origin"})},
            {"measured",
             {{"lut", without(a[7], {"grey_levels", "phase_rad", "standard_error_rad", "origin"})},
              {"flatness", without(a[8], {"origin"})},
              {"registration", a[9]},
              {"calibration", seldom(calibration_, "calibration.get", jobs)}}},
            {"settle_ms", a[0]["slm"]["settle_ms"]},
            {"references",
             seldom(references_, "reference.list", jobs).value("references", json::array())},
            {"identified", a[10]["model"]},
            {"limits", limits_of_wire()},
            {"hologram", hologram_of({a[0], a[2], a[3], a[4], a[7], a[8],
                                      a[11].at("slm").at("pattern").get<std::string>()})}};
  if (view == last_) return std::nullopt;
  last_ = view;
  return view;
}

}  // namespace ovws::web
