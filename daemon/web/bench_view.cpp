#include "daemon/web/bench_view.hpp"

#include "config/config.hpp"
#include "core/optics/zernike.hpp"
#include "core/tracking/spot.hpp"
#include "core/tracking/spot_geometry.hpp"
#include "proto/json_text.hpp"
#include "proto/limits.hpp"
#include "proto/names.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

/// Limits the redraw rate: a closed loop makes up to ten holograms per second.
constexpr std::chrono::milliseconds kDrawPeriod{500};

/// Radius of the bright ring (vortex) or of the bright spot (charge 0), camera pixels.
double ring_px(const Config& config) {
  const SpotGeometry shape = spot_geometry(config.sensor.charge);
  const double lambdas = config.sensor.charge == 0 ? shape.ring_outer : shape.ring;
  return lambdas * lambda_d_px(config.optics, config.slm.geometry, config.sensor);
}

json sensor_of(const json& sensor, const json& config_json) {
  json view = sensor;
  view["mode_names"] = json::array();
  for (const json& j : sensor.at("modes_j")) {
    const ZernikeIndex index = zernike_index(j.get<int>());
    view["mode_names"].push_back(
        {{"j", j}, {"n", index.n}, {"m", index.m}, {"name", zernike_name(j.get<int>())}});
  }
  const auto config = parse_config(json_text(config_json));
  view["ring_px"] = config ? json(ring_px(*config)) : json(nullptr);
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

json reference_of(json reference) {
  reference.erase("positions_px");
  reference.erase("standard_error_px");
  reference.erase("origin");
  return reference;
}

}  // namespace

json BenchView::hologram_of(const HologramSources& sources) {
  const auto now = Clock::now();
  if (sources != drawn_ && now - drawn_at_ > kDrawPeriod) {
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

std::optional<json> BenchView::look(const std::string& pattern) {
  const auto answers = cli::call_all(
      common_, {"config.get", "camera.get", "sensor.get", "aberration.get", "correction.get",
                "loop.get", "reference.get", "lut.get", "flatness.get"});
  if (!answers) return std::nullopt;
  const std::vector<json>& a = *answers;
  json view{{"schema", "ovws.web.bench/1"},
            {"camera", a[1]},
            {"sensor", sensor_of(a[2], a[0])},
            {"optics", a[0]["optics"]},
            {"aberration", a[3]},
            {"correction", a[4]},
            {"loop", a[5]},
            {"reference", reference_of(a[6])},
            {"limits", limits_of_wire()},
            {"hologram", hologram_of({a[0], a[2], a[3], a[4], a[7], a[8], pattern})}};
  if (view == last_) return std::nullopt;
  last_ = view;
  return view;
}

}  // namespace ovws::web
