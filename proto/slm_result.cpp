#include "proto/slm_result.hpp"

#include <cmath>
#include <initializer_list>
#include <numbers>

#include "proto/results.hpp"

namespace ovws {
namespace {

using nlohmann::json;

json text_or_null(const std::string& text) {
  return text.empty() ? json(nullptr) : json(text);
}

void add_nulls(json& to, std::initializer_list<const char*> keys) {
  for (const char* key : keys) to[key] = nullptr;
}

}  // namespace

json lut_result(const LutReport& lut) {
  json result{{"source", lut.measured ? "measured"
                         : lut.path   ? "file"
                                      : "linear"},
              {"path", lut.path ? json(*lut.path) : json(nullptr)},
              {"grey_levels", lut.in_force},
              {"measured", lut.measured.has_value()}};
  if (!lut.measured) {
    add_nulls(result, {"t_taken_ns", "t_taken", "sha256", "frames", "levels", "phase_rad",
                       "standard_error_rad", "noise_rad", "residual_rad", "depth_rad", "falls",
                       "reaches_2pi", "steps_out_of_reach", "reason", "origin"});
    return result;
  }
  const LutReport::Measured& m = *lut.measured;
  result.update({{"t_taken_ns", m.t_taken_ns},
                 {"t_taken", utc_text(m.t_taken_ns)},
                 {"sha256", text_or_null(m.sha256)},
                 {"frames", m.frames},
                 {"levels", m.response.levels},
                 {"phase_rad", m.response.phase_rad},
                 {"standard_error_rad", m.response.standard_error_rad},
                 {"noise_rad", m.response.noise_rad},
                 {"residual_rad", m.response.residual_rad},
                 {"depth_rad", m.response.depth_rad()},
                 {"falls", m.response.falls()},
                 {"reaches_2pi", m.table.reason.empty()},
                 {"steps_out_of_reach", m.table.steps_out_of_reach},
                 {"reason", text_or_null(m.table.reason)},
                 {"origin", m.origin}});
  return result;
}

json flatness_result(const FlatnessReport& flatness) {
  json result{{"path", flatness.path ? json(*flatness.path) : json(nullptr)},
              {"measured", flatness.measured.has_value()}};
  if (!flatness.measured) {
    add_nulls(result, {"t_taken_ns", "t_taken", "sha256", "frames", "iterations",
                       "pupil_diameter_px", "modes", "rms_waves", "residual_rms_waves", "origin"});
    return result;
  }
  const FlatnessReport::Measured& m = *flatness.measured;
  json modes = json::array();
  double square = 0.0;
  for (std::size_t k = 0; k < m.modes.size(); ++k) {
    modes.push_back({{"j", m.modes[k].j},
                     {"waves", m.modes[k].waves},
                     {"standard_error_waves", m.standard_error_waves[k]}});
    square += m.modes[k].waves * m.modes[k].waves;
  }
  result.update({{"t_taken_ns", m.t_taken_ns},
                 {"t_taken", utc_text(m.t_taken_ns)},
                 {"sha256", text_or_null(m.sha256)},
                 {"frames", m.frames},
                 {"iterations", m.iterations},
                 {"pupil_diameter_px", m.pupil_diameter_px},
                 {"modes", std::move(modes)},
                 {"rms_waves", std::sqrt(square)},
                 {"residual_rms_waves", m.residual_rms_waves},
                 {"origin", m.origin}});
  return result;
}

namespace {

/// What is wrong with slm.settle_ms; empty: nothing.
std::string settle_reason(const SettleTime& time, double configured_ms) {
  const auto text = [](double ms) {
    const long tenths = std::lround(10.0 * ms);
    return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " ms";
  };
  if (configured_ms < time.max_ms) {
    return "slm.settle_ms is " + text(configured_ms) + ", and the picture stands after " +
           text(time.max_ms) +
           ": frames are taken for settled that are not; set slm.settle_ms to " +
           std::to_string(std::lround(time.proposed_ms));
  }
  if (configured_ms < time.worst_ms) {
    return std::to_string(time.outliers) + " changes took up to " + text(time.worst_ms) +
           ", longer than slm.settle_ms (" + text(configured_ms) +
           "): if this machine was not busy then, the SLM's controller is slower at times; measure "
           "again, and set slm.settle_ms above it if it stays";
  }
  return {};
}

}  // namespace

json settle_result(const SettleTime& time, int repetitions, double configured_ms) {
  const std::string reason = settle_reason(time, configured_ms);
  return {{"repetitions", repetitions},
          {"p50_ms", time.p50_ms},
          {"mad_ms", time.mad_ms},
          {"max_ms", time.max_ms},
          {"worst_ms", time.worst_ms},
          {"outliers", time.outliers},
          {"least_ms", time.least_ms},
          {"resolution_ms", time.resolution_ms},
          {"margin_ms", time.margin_ms},
          {"proposed_settle_ms", time.proposed_ms},
          {"configured_settle_ms", configured_ms},
          {"long_enough", configured_ms >= time.max_ms},
          {"reason", text_or_null(reason)}};
}

json verify_result(const VerifyReport& report) {
  return {{"hologram_id", report.hologram_id},
          {"crc32", report.crc32},
          {"crc32_shown", report.crc32_shown},
          {"equal", report.differing_pixels == 0},
          {"differing_pixels", report.differing_pixels}};
}

}  // namespace ovws
