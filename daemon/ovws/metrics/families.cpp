#include "daemon/ovws/metrics/families.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>

#include "core/optics/zernike.hpp"
#include "core/rt/counters.hpp"
#include "proto/daemon_state.hpp"
#include "proto/json_part.hpp"

namespace ovws::metrics {
namespace {

using nlohmann::json;
using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;
using Families = std::vector<MetricFamily>;
using Labels = std::vector<ClientMetric::Label>;

struct GaugeRow {
  const char* path;  ///< JSON pointer in the message
  const char* name;
  const char* help;
  double unit = 1.0;  ///< factor from the message's unit to the metric's
};

constexpr GaugeRow kStatusGauges[]{
    {"/uptime_s", "ovws_uptime_seconds", "Time since the daemon's start."},
    {"/camera/connected", "ovws_camera_connected", "Whether a camera is connected."},
    {"/camera/streaming", "ovws_camera_streaming", "Whether frames arrive."},
    {"/camera/settings/gain_db", "ovws_camera_gain_decibels", "The camera's gain."},
    {"/camera/settings/gain_raw", "ovws_camera_gain_raw",
     "The camera's gain in raw steps, if it has none in dB."},
    {"/camera/settings/exposure_us", "ovws_camera_exposure_seconds", "The camera's exposure.",
     1e-6},
    {"/camera/settings/frame_rate_hz", "ovws_camera_frame_rate_hertz",
     "The requested frame rate of the camera."},
    {"/slm/connected", "ovws_slm_connected", "Whether the SLM's display is usable."},
    {"/slm/settled", "ovws_slm_settled", "Whether the hologram has settled."},
    {"/slm/hologram_id", "ovws_slm_hologram_id", "Number of the displayed hologram."},
    {"/sensor/charge", "ovws_sensor_charge", "Topological charge; 0: bright spots."},
    {"/sensor/subapertures", "ovws_sensor_subapertures", "Number of subapertures."},
    {"/sensor/modes", "ovws_sensor_modes", "Number of reconstructed modes."},
    {"/sensor/referenced", "ovws_sensor_referenced", "Whether the sensor has a reference."},
    {"/rates/images_hz", "ovws_images_rate_hertz", "Images published per second."},
    {"/refine/last_duration_ms", "ovws_refine_last_duration_seconds",
     "Duration of the last refining fit.", 1e-3},
};

constexpr GaugeRow kWavefrontGauges[]{
    {"/valid", "ovws_wavefront_valid", "Whether the newest frame's wavefront is valid."},
    {"/rms_waves", "ovws_wavefront_rms_waves",
     "RMS of the newest frame's wavefront without tilts, waves."},
    {"/fit_residual_px", "ovws_wavefront_fit_residual_pixels",
     "RMS of the displacements that the modes do not explain, camera pixels."},
    {"/wavelength_nm", "ovws_wavefront_wavelength_meters", "Wavelength.", 1e-9},
    {"/tracked", "ovws_spots_tracked", "Spots found in the newest frame."},
    {"/saturated", "ovws_spots_saturated_ratio", "Fraction of spots with a saturated pixel."},
};

/// JSON object or array at this path; an empty one if there is none.
json part_at(const json& message, const std::string& path, json::value_t type) {
  const json& value = ovws::part_at(message, path);
  return value.type() == type ? value : json(type);
}

ClientMetric gauge(double value, Labels labels = {}) {
  ClientMetric metric;
  metric.label = std::move(labels);
  metric.gauge.value = value;
  return metric;
}

void add_gauge(Families& out, const char* name, const char* help, double value) {
  out.push_back({name, help, MetricType::Gauge, {gauge(value)}});
}

void add_gauges(Families& out, const json& message, std::span<const GaugeRow> rows) {
  for (const GaugeRow& row : rows) {
    const auto value = number_at(message, row.path);
    if (value) add_gauge(out, row.name, row.help, *value * row.unit);
  }
}

void add_counter(Families& out, const std::string& name, std::string help, double value) {
  ClientMetric metric;
  metric.counter.value = value;
  out.push_back({name, std::move(help), MetricType::Counter, {metric}});
}

void add_counters(Families& out, const json& status) {
  const json counters = part_at(status, "/counters", json::value_t::object);
  for (const auto& [name, count] : counters.items()) {
    const auto known = std::ranges::find(all_counters(), name, &CounterRow::name);
    if (!count.is_number()) continue;
    add_counter(out, "ovws_" + name + "_total",
                known == all_counters().end() ? "Counter of a newer daemon: see its WIRE.md."
                                              : std::string(known->help),
                count.get<double>());
  }
  const std::pair<const char*, const char*> fits[]{{"done", "Frames refined."},
                                                   {"refused", "Frames that no fit explains."}};
  for (const auto& [key, help] : fits) {
    const auto count = number_at(status, std::string("/refine/") + key);
    if (count) add_counter(out, std::string("ovws_refine_") + key + "_total", help, *count);
  }
}

/// State set in Prometheus: one series per state, 1 for the current state and 0 for all others.
/// States can be graphed this way, and a previous state does not stay at 1.
template <class Names>
MetricFamily one_of(const char* name, const char* help, const char* label, const Names& names,
                    const std::string& holds) {
  MetricFamily family{name, help, MetricType::Gauge, {}};
  for (const std::string_view one : names) {
    family.metric.push_back(gauge(one == holds ? 1.0 : 0.0, {{label, std::string(one)}}));
  }
  return family;
}

void add_states(Families& out, const json& status) {
  out.push_back(one_of("ovws_state", "The daemon's state: 1 for the current one.", "state",
                       kStateNames, text_at(status, "/state")));
  out.push_back(one_of("ovws_reference", "State of the reference: 1 for the current one.", "state",
                       std::array{"none", "in_force", "stale"},
                       text_at(status, "/sensor/reference")));
  out.push_back(one_of("ovws_tracker", "The active tracker.", "tracker",
                       std::array{text_at(status, "/sensor/tracker")},
                       text_at(status, "/sensor/tracker")));
  const auto loop = text_at(status, "/loop");
  add_gauge(out, "ovws_loop_closed", "Whether the loop is closed.",
            loop == "closed" || loop == "paused" ? 1.0 : 0.0);
}

void add_versions(Families& out, const json& status) {
  Labels labels;
  const json versions = part_at(status, "/versions", json::value_t::object);
  for (const auto& [name, version] : versions.items()) {
    std::string label = name;
    for (char& c : label) {
      if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    }
    if (version.is_string()) labels.push_back({label, version.get<std::string>()});
  }
  out.push_back({"ovws_build_info",
                 "Versions of the daemon and its libraries, as labels; always 1.",
                 MetricType::Gauge,
                 {gauge(1.0, std::move(labels))}});
}

/// Latency histogram of a stage; none unless its edges and counts are complete.
std::optional<ClientMetric> histogram(const std::string& stage, const json& latency) {
  const json totals = part_at(latency, "/since_start", json::value_t::object);
  const json edges = part_at(totals, "/edges_us", json::value_t::array);
  const json below = part_at(totals, "/below", json::value_t::array);
  const auto count = number_at(totals, "/count");
  const auto sum_us = number_at(totals, "/sum_us");
  if (!count || !sum_us || edges.empty() || edges.size() != below.size()) return std::nullopt;
  ClientMetric metric;
  metric.label = {{"stage", stage}};
  metric.histogram.sample_count = std::uint64_t(*count);
  metric.histogram.sample_sum = 1e-6 * *sum_us;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (!edges[e].is_number() || !below[e].is_number()) return std::nullopt;
    // Division gives shorter decimal bucket labels than multiplication by 1e-6.
    metric.histogram.bucket.push_back(
        {below[e].get<std::uint64_t>(), edges[e].get<double>() / 1e6});
  }
  return metric;
}

void add_latencies(Families& out, const json& status) {
  MetricFamily family{"ovws_frame_latency_seconds",
                      "Latency from a frame's arrival until it was tracked, reconstructed, "
                      "published; arrived: the delay of its arrival.",
                      MetricType::Histogram,
                      {}};
  const json latency = part_at(status, "/latency", json::value_t::object);
  for (const auto& [stage, one] : latency.items()) {
    if (auto metric = histogram(stage, one)) family.metric.push_back(std::move(*metric));
  }
  out.push_back(std::move(family));
}

void add_coefficients(Families& out, const json& wavefront) {
  MetricFamily family{"ovws_wavefront_coefficient_waves",
                      "Zernike coefficients (OSA/ANSI, RMS-normalised) of the newest frame, waves.",
                      MetricType::Gauge,
                      {}};
  const json modes = part_at(wavefront, "/j", json::value_t::array);
  const json values = part_at(wavefront, "/coefficients", json::value_t::array);
  for (std::size_t k = 0; k < modes.size() && k < values.size(); ++k) {
    if (!modes[k].is_number_integer() || !values[k].is_number()) continue;
    const int j = modes[k].get<int>();
    if (j < 0 || j > kMaxZernikeIndex) continue;
    family.metric.push_back(
        gauge(values[k].get<double>(), {{"j", std::to_string(j)}, {"mode", zernike_name(j)}}));
  }
  if (!family.metric.empty()) out.push_back(std::move(family));
}

void add_wavefront(Families& out, const json& wavefront) {
  add_gauges(out, wavefront, kWavefrontGauges);
  const auto there = number_at(wavefront, "/subapertures");
  const auto found = number_at(wavefront, "/tracked");
  if (there && found) {
    add_gauge(out, "ovws_spots_missing", "Spots not found in the newest frame.", *there - *found);
  }
  add_coefficients(out, wavefront);
}

}  // namespace

std::vector<MetricFamily> families(const std::optional<json>& status,
                                   const std::optional<json>& wavefront) {
  Families out;
  add_gauge(out, "ovws_up", "Whether the daemon publishes its status.", status ? 1.0 : 0.0);
  if (!status) return out;
  add_versions(out, *status);
  add_states(out, *status);
  add_gauges(out, *status, kStatusGauges);
  add_counters(out, *status);
  add_latencies(out, *status);
  if (wavefront) add_wavefront(out, *wavefront);
  return out;
}

}  // namespace ovws::metrics
