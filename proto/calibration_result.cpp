#include "proto/calibration_result.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "proto/results.hpp"

namespace ovws {
namespace {

using nlohmann::json;

json modes_json(const CalibrationReport& report) {
  const InteractionMatrix& matrix = report.matrix;
  const int found = matrix.spots() - int(matrix.lost_spots.size());
  const double by = 1.0 / std::sqrt(2.0 * std::max(1, found));
  json modes = json::array();
  for (std::size_t k = 0; k < matrix.modes_j.size(); ++k) {
    const int j = matrix.modes_j[k];
    json mode{
        {"j", j},
        {"amplitude_waves", matrix.amplitude_waves[k]},
        {"signal_px_per_wave", by * matrix.slopes.col(Eigen::Index(k)).norm()},
        {"standard_error_px_per_wave", by * matrix.standard_error.col(Eigen::Index(k)).norm()},
        {"factor", nullptr},
        {"factor_standard_error", nullptr},
        {"correlation", nullptr}};
    const auto& compared = report.comparison.modes;
    const auto at = std::find_if(compared.begin(), compared.end(),
                                 [j](const ModeComparison& one) { return one.j == j; });
    if (at != compared.end()) {
      mode["factor"] = at->factor;
      mode["factor_standard_error"] = at->factor_standard_error;
      mode["correlation"] = at->correlation;
    }
    modes.push_back(std::move(mode));
  }
  return modes;
}

json dropped_json(const std::vector<DroppedMode>& dropped) {
  json all = json::array();
  for (const DroppedMode& one : dropped) all.push_back({{"j", one.j}, {"reason", one.reason}});
  return all;
}

}  // namespace

std::string_view disagreement_name(Disagreement disagreement) {
  constexpr std::array<std::string_view, 9> kNames{
      "none", "sign", "axes", "scale", "rotation", "parity", "order", "single_modes", "unlike"};
  return kNames[std::size_t(disagreement)];
}

json calibration_result(const std::optional<CalibrationReport>& calibration) {
  if (!calibration) {
    json none{{"calibrated", false}, {"in_force", false}};
    for (const char* key :
         {"t_taken_ns", "t_taken", "sha256", "amplitude_waves", "frames", "subapertures",
          "lost_spots", "modes", "dropped", "singular_values_px_per_wave", "condition_number",
          "drift_px", "drift_noise_px", "disagreement", "disagreement_reason", "origin"}) {
      none[key] = nullptr;
    }
    return none;
  }
  const CalibrationReport& c = *calibration;
  const Eigen::VectorXd values = singular_values(c.matrix);
  const std::string& words = c.comparison.words;
  return {{"calibrated", true},
          {"in_force", c.in_force},
          {"t_taken_ns", c.t_taken_ns},
          {"t_taken", utc_text(c.t_taken_ns)},
          {"sha256", c.sha256.empty() ? json(nullptr) : json(c.sha256)},
          {"amplitude_waves", c.amplitude_waves},
          {"frames", c.frames},
          {"subapertures", c.matrix.spots()},
          {"lost_spots", c.matrix.lost_spots},
          {"modes", modes_json(c)},
          {"dropped", dropped_json(c.matrix.dropped)},
          {"singular_values_px_per_wave", std::vector<double>(values.begin(), values.end())},
          {"condition_number", values[0] / values[values.size() - 1]},
          {"drift_px", c.matrix.drift_px},
          {"drift_noise_px", c.matrix.drift_noise_px},
          {"disagreement", disagreement_name(c.comparison.disagreement)},
          {"disagreement_reason", words.empty() ? json(nullptr) : json(words)},
          {"origin", c.origin}};
}

}  // namespace ovws
