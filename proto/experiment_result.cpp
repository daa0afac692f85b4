#include "proto/experiment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "proto/tables/time.hpp"

namespace ovws {
namespace {

using nlohmann::json;

json number_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

/// To a millionth: what a file holds is then short, and far below any noise.
json short_number(double value) {
  return number_or_null(std::round(1e6 * value) / 1e6);
}

json places_json(const std::vector<Vec2>& places) {
  json all = json::array();
  for (const Vec2 p : places) all.push_back({number_or_null(p.x), number_or_null(p.y)});
  return all;
}

void put_levels(json& out, const SpotLevels& levels) {
  out["level_dn"] = short_number(levels.level_dn);
  out["noise_dn"] = short_number(levels.noise_dn);
  out["peak_dn"] = short_number(levels.peak_dn);
}

/// Mean, standard deviation and standard error.
void put_variance(json& out, const CellMeasured& cell) {
  std::vector<double> all, unsaturated;
  for (const auto& frame : cell.frames) {
    if (!std::isfinite(frame.variance_rad2)) continue;
    all.push_back(frame.variance_rad2);
    if (frame.saturated_fraction == 0.0) unsaturated.push_back(frame.variance_rad2);
  }
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / double(values.size());  // NaN of none
  };
  double squares = 0.0;
  for (const double value : all) squares += (value - mean(all)) * (value - mean(all));
  const double deviation = all.size() > 1 ? std::sqrt(squares / double(all.size() - 1)) : NAN;
  out["variance_rad2"] = number_or_null(mean(all));
  out["standard_deviation_rad2"] = number_or_null(deviation);
  out["standard_error_rad2"] = number_or_null(deviation / std::sqrt(double(all.size())));
  out["unsaturated_variance_rad2"] = number_or_null(mean(unsaturated));
  out["undetermined_frames"] = cell.frames.size() - all.size();
}

void put_frames(json& out, const CellMeasured& cell) {
  json variances = json::array(), coefficients = json::array(), saturated = json::array(),
       tracked = json::array();
  int saturated_frames = 0, lost_spots = 0;
  for (const auto& frame : cell.frames) {
    variances.push_back(number_or_null(frame.variance_rad2));
    json row = json::array();
    for (const double waves : frame.coefficients) row.push_back(short_number(waves));
    coefficients.push_back(std::move(row));
    saturated.push_back(short_number(frame.saturated_fraction));
    tracked.push_back(frame.tracked);
    saturated_frames += frame.saturated_fraction > 0.0 ? 1 : 0;
    lost_spots += cell.subapertures - frame.tracked;
  }
  out["saturated_frames"] = saturated_frames;
  out["lost_spots"] = lost_spots;
  out["modes_j"] = cell.modes_j;
  out["variances_rad2"] = std::move(variances);
  out["coefficients_waves"] = std::move(coefficients);
  out["saturated_fractions"] = std::move(saturated);
  out["tracked"] = std::move(tracked);
}

/// Without what is of single frames.
json summary_of(const json& cell) {
  constexpr std::array<std::string_view, 6> kOfFrames{
      "modes_j", "variances_rad2", "coefficients_waves", "saturated_fractions",
      "tracked", "picture"};
  json summary = json::object();
  for (const auto& [key, value] : cell.items()) {
    if (std::find(kOfFrames.begin(), kOfFrames.end(), key) == kOfFrames.end()) {
      summary[key] = value;
    }
  }
  return summary;
}

json known_of(const std::vector<json>& items, bool summarised) {
  json known = json::array();
  for (const json& item : items) {
    if (!item.is_null()) known.push_back(summarised ? summary_of(item) : item);
  }
  return known;
}

template <class T>
json or_null(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}

}  // namespace

json to_json(const GainSweep& sweep, const ReferenceMeasured& reference) {
  json out = to_json(sweep.arms[std::size_t(reference.arm)]);
  out["arm"] = reference.arm;
  out["gain_db"] = reference.gain_db;
  out["t_begun_ns"] = reference.t_begun_ns;
  out["frames"] = reference.frames;
  out["saturated_frames"] = reference.saturated_frames;
  put_levels(out, reference.levels);
  out["positions_px"] = places_json(reference.positions_px);
  out["cells_px"] = places_json(reference.cells_px);
  return out;
}

std::optional<std::vector<Vec2>> reference_places(const json& reference, int arm, const char* key) {
  if (!reference.is_object() || reference.value("arm", -1) != arm) return std::nullopt;
  std::vector<Vec2> positions;
  const auto number = [](const json& value) {
    return value.is_number() ? value.get<double>() : NAN;
  };
  for (const json& one : reference.value(key, json::array())) {
    if (!one.is_array() || one.size() != 2) return std::nullopt;
    positions.push_back({number(one[0]), number(one[1])});
  }
  return positions;
}

json to_json(const GainSweep& sweep, const CellMeasured& cell) {
  const GainSweep::Cell at = sweep.cell(std::size_t(cell.cell));
  json out = to_json(sweep.arms[at.arm]);
  out["cell"] = cell.cell;
  out["arm"] = at.arm;
  out["aberration"] = at.aberration;
  out["gain_db"] = cell.gain_db;
  out["exposure_us"] = cell.exposure_us;
  out["frame_rate_hz"] = cell.frame_rate_hz;
  out["t_begun_ns"] = cell.t_begun_ns;
  out["frames"] = cell.frames.size();
  put_variance(out, cell);
  put_frames(out, cell);
  put_levels(out, cell.levels);
  out["picture"] = nullptr;
  if (cell.picture) {
    out["picture"] = {{"width", cell.picture->width},
                      {"height", cell.picture->height},
                      {"base64", cell.picture->base64}};
  }
  return out;
}

json experiment_result(const ExperimentReport* report) {
  if (report == nullptr) {
    json none{{"known", false}, {"complete", false}, {"cells_total", 0}, {"cells_done", 0}};
    for (const char* key : {"run", "job", "t_begun_ns", "t_begun", "time_left_s", "not_kept_reason",
                            "request", "bench", "references", "cells"}) {
      none[key] = nullptr;
    }
    return none;
  }
  json cells = known_of(report->cells, true);
  const std::size_t done = cells.size();
  return {{"known", true},
          {"complete", done == report->cells.size()},
          {"run", report->run},
          {"job", or_null(report->job)},
          {"t_begun_ns", report->t_begun_ns},
          {"t_begun", utc_text(report->t_begun_ns)},
          {"time_left_s", or_null(report->time_left_s)},
          {"not_kept_reason", or_null(report->not_kept_reason)},
          {"request", to_json(report->request)},
          {"bench", report->bench},
          {"references", known_of(report->references, false)},
          {"cells_total", report->cells.size()},
          {"cells_done", done},
          {"cells", std::move(cells)}};
}

}  // namespace ovws
