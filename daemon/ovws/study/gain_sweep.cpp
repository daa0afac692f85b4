#include "daemon/ovws/study/gain_sweep.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <sstream>

#include "core/optics/zernike.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "proto/field_json.hpp"
#include "proto/json_text.hpp"

namespace ovws {

const std::vector<std::string>& sweep_tracker_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = kNames<TrackerKind>();
    all.emplace_back("cell_centroid");
    return all;
  }();
  return names;
}

Json Wire<SweepTracker>::to_json(const SweepTracker& tracker) {
  return tracker.fixed_cell ? sweep_tracker_names().back()
                            : std::string(tracker_name(tracker.kind));
}

void Wire<SweepTracker>::decode(ObjectReader& reader, const FieldInfo& field, SweepTracker& out) {
  int value = int(out.kind);
  reader.choice(field.key, value, sweep_tracker_names());
  out.fixed_cell = std::size_t(value) == kNames<TrackerKind>().size();
  out.kind = out.fixed_cell ? TrackerKind::centroid : TrackerKind(value);
}

std::vector<ModesSet> paper_aberrations() {
  constexpr int kObliqueAstigmatism = 3;
  std::vector<ModesSet> all;
  for (const double unit_waves : {0.5, 1.5, 2.0}) {
    all.push_back({{{kObliqueAstigmatism, unit_waves / zernike_rms_factor(kObliqueAstigmatism)}}});
  }
  return all;
}

GainSweep::Cell GainSweep::cell(std::size_t number) const {
  const std::size_t row = number / arms.size();
  return {number % arms.size(), row / gains_db.size(), row % gains_db.size()};
}

namespace {

/// Rounds to 1e-6, which keeps the numbers in files short and is far below any noise. Null: NaN.
Json to_millionth(double value) {
  return study::number_or_null(std::round(1e6 * value) / 1e6);
}

Json json_of(const SpotLevels& levels) {
  return {{"level_dn", to_millionth(levels.level_dn)},
          {"noise_dn", to_millionth(levels.noise_dn)},
          {"peak_dn", to_millionth(levels.peak_dn)}};
}

/// Columns of the residual phase variances of a cell's frames.
Json variance_of(const CellMeasured& cell) {
  int saturated_frames = 0, lost_spots = 0;
  std::vector<double> all, unsaturated;
  for (const CellMeasured::Frame& frame : cell.frames) {
    saturated_frames += frame.saturated_fraction > 0.0 ? 1 : 0;
    lost_spots += cell.subapertures - frame.tracked;
    if (!std::isfinite(frame.variance_rad2)) continue;
    all.push_back(frame.variance_rad2);
    if (frame.saturated_fraction == 0.0) unsaturated.push_back(frame.variance_rad2);
  }
  const study::Mean mean = study::mean_of(all);
  const double error = all.size() > 1 ? mean.standard_error : study::kUnknown;
  const auto root_count = std::sqrt(double(all.size()));
  return {{"variance_rad2", study::number_or_null(mean.value)},
          {"standard_deviation_rad2", study::number_or_null(error * root_count)},
          {"standard_error_rad2", study::number_or_null(error)},
          {"unsaturated_variance_rad2", study::number_or_null(study::mean_of(unsaturated).value)},
          {"undetermined_frames", cell.frames.size() - all.size()},
          {"saturated_frames", saturated_frames},
          {"lost_spots", lost_spots}};
}

Json json_of(const std::vector<Vec2>& places) {
  Json all = Json::array();
  for (const Vec2 at : places) {
    all.push_back(std::isnan(at.x) ? Json() : Json{at.x, at.y});
  }
  return all;
}

}  // namespace

Json report_of(const ReferenceMeasured& reference) {
  Json report = to_json(reference.with);
  report.update(json_of(reference.levels));
  report.update({{"arm", reference.arm},
                 {"gain_db", reference.gain_db},
                 {"t_begun_ns", reference.t_begun_ns},
                 {"frames", reference.frames},
                 {"saturated_frames", reference.saturated_frames},
                 {"positions_px", json_of(reference.positions_px)},
                 {"cells_px", json_of(reference.cells_px)}});
  return report;
}

Json report_of(const CellMeasured& cell) {
  Json report = to_json(cell.with);
  report.update(variance_of(cell));
  report.update(json_of(cell.levels));
  report.update({{"cell", cell.cell},
                 {"arm", cell.at.arm},
                 {"aberration", cell.at.aberration},
                 {"gain_db", cell.gain_db},
                 {"exposure_us", cell.exposure_us},
                 {"frame_rate_hz", cell.frame_rate_hz},
                 {"t_begun_ns", cell.t_begun_ns},
                 {"frames", cell.frames.size()},
                 {"modes_j", cell.modes_j}});
  for (const CellMeasured::Frame& frame : cell.frames) {
    Json waves = Json::array();
    for (const double one : frame.coefficients) waves.push_back(to_millionth(one));
    report["coefficients_waves"].push_back(std::move(waves));
    report["variances_rad2"].push_back(study::number_or_null(frame.variance_rad2));
    report["saturated_fractions"].push_back(to_millionth(frame.saturated_fraction));
    report["tracked"].push_back(frame.tracked);
  }
  return report;
}

Json summary_of(Json cell_report) {
  for (const char* key :
       {"modes_j", "coefficients_waves", "variances_rad2", "saturated_fractions", "tracked"}) {
    cell_report.erase(key);
  }
  return cell_report;
}

}  // namespace ovws

namespace ovws::study {
namespace {

using nlohmann::json;

/// Columns of cells.csv.
constexpr const char* kColumns =
    "cell,charge,tracker,aberration,gain_db,frames,variance_rad2,standard_deviation_rad2,"
    "standard_error_rad2,unsaturated_variance_rad2,undetermined_frames,saturated_frames,lost_spots,"
    "level_dn,noise_dn,peak_dn,exposure_us,frame_rate_hz,t_begun_ns,arm";

std::string text_of(const json& value) {
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : json_text(value);
}

double number_of(const json& value) {
  return value.is_number() ? value.get<double>() : kUnknown;
}

/// The cell with this number, or null.
const json& cell_at(const json& experiment, std::size_t number) {
  static const json none;
  for (const json& cell : experiment["cells"]) {
    if (cell["cell"] == number) return cell;
  }
  return none;
}

std::size_t number_at(const json& request, std::size_t aberration, std::size_t gain,
                      std::size_t arm) {
  return (aberration * request["gains_db"].size() + gain) * request["arms"].size() + arm;
}

double variance_at(const json& experiment, std::size_t number) {
  const json& cell = cell_at(experiment, number);
  return cell.is_null() ? number_of(cell) : number_of(cell["variance_rad2"]);
}

/// Calls `each(aberration, gain, arm)` for every cell of the sweep, measured or not.
template <class Each>
void for_places(const json& request, Each each) {
  for (std::size_t a = 0; a < request["aberrations"].size(); ++a) {
    for (std::size_t g = 0; g < request["gains_db"].size(); ++g) {
      for (std::size_t k = 0; k < request["arms"].size(); ++k) each(a, g, k);
    }
  }
}

}  // namespace

std::string cells_csv_header() {
  return std::string(kColumns) + "\n";
}

std::string cells_csv_row(const json& cell) {
  std::string row;
  std::istringstream keys(kColumns);
  for (std::string key; std::getline(keys, key, ',');) {
    row += (row.empty() ? "" : ",") + text_of(cell.at(key));
  }
  return row + "\n";
}

std::string frames_csv_header(const json& cell) {
  std::string text = "cell,frame,variance_rad2,saturated_fraction,tracked";
  for (const json& j : cell["modes_j"]) text += fmt::format(",j{}_waves", j.get<int>());
  return text + "\n";
}

std::string frames_csv_rows(const json& cell) {
  std::string text;
  for (std::size_t k = 0; k < cell["variances_rad2"].size(); ++k) {
    text += fmt::format("{},{},{},{},{}", cell["cell"].get<int>(), k,
                        text_of(cell["variances_rad2"][k]), text_of(cell["saturated_fractions"][k]),
                        text_of(cell["tracked"][k]));
    const json& waves = cell["coefficients_waves"][k];
    for (std::size_t i = 0; i < cell["modes_j"].size(); ++i) {
      text += "," + (i < waves.size() ? text_of(waves[i]) : "");
    }
    text += "\n";
  }
  return text;
}

std::string arm_name(const json& arm) {
  return fmt::format("charge {}, {}", arm["charge"].get<int>(), arm["tracker"].get<std::string>());
}

std::string aberration_name(const json& aberration) {
  std::string text;
  for (const json& mode : aberration["modes"]) {
    const int j = mode["j"].get<int>();
    const double waves = mode["waves"].get<double>();
    text += fmt::format("{}{}, {:.3f} wave RMS ({:.3g} unit amplitude)", text.empty() ? "" : "; ",
                        zernike_name(j), waves, waves * zernike_rms_factor(j));
  }
  return text.empty() ? "no aberration" : text;
}

std::string sweep_table(const json& experiment) {
  const json& request = experiment["request"];
  std::string text =
      "Mean residual variance, rad^2; * some frames saturated; - no frame with modes\n";
  for_places(request, [&](std::size_t a, std::size_t g, std::size_t k) {
    if (g == 0 && k == 0) {
      text += fmt::format("\n{}\n{:>8}", aberration_name(request["aberrations"][a]), "gain/dB");
      for (const json& arm : request["arms"]) text += fmt::format("  {:>24}", arm_name(arm));
      text += "\n";
    }
    if (k == 0) text += fmt::format("{:>8g}", request["gains_db"][g].get<double>());
    const json& cell = cell_at(experiment, number_at(request, a, g, k));
    std::string entry = "-";
    if (!cell.is_null() && cell["variance_rad2"].is_number()) {
      entry = fmt::format("{:.3g} +- {:.1g}{}", number_of(cell["variance_rad2"]),
                          number_of(cell["standard_error_rad2"]),
                          cell["saturated_frames"].get<int>() > 0 ? "*" : " ");
    }
    text += fmt::format("  {:>24}", entry);
    if (k + 1 == request["arms"].size()) text += "\n";
  });
  return text;
}

std::vector<Figure> sweep_figures(const json& experiment) {
  const json& request = experiment["request"];
  std::vector<Figure> figures;
  for_places(request, [&](std::size_t a, std::size_t g, std::size_t k) {
    if (g == 0 && k == 0) {
      Figure figure{fmt::format("experiment-variance-{}", a + 1),
                    aberration_name(request["aberrations"][a]), "camera gain (dB)",
                    "mean residual phase variance (rad^2)"};
      figure.log_y = true;
      for (const json& arm : request["arms"]) figure.series.push_back({arm_name(arm), {}, {}, {}});
      figures.push_back(std::move(figure));
    }
    Series& series = figures[a].series[k];
    const json& cell = cell_at(experiment, number_at(request, a, g, k));
    series.x.push_back(request["gains_db"][g].get<double>());
    series.y.push_back(cell.is_null() ? number_of(cell) : number_of(cell["variance_rad2"]));
    const double error = cell.is_null() ? number_of(cell) : number_of(cell["standard_error_rad2"]);
    series.error.push_back(std::isfinite(error) ? error : 0.0);
  });
  return figures;
}

Comparison compare_arms(const json& experiment, std::size_t arm, std::size_t other) {
  const json& request = experiment["request"];
  Comparison result;
  for_places(request, [&](std::size_t a, std::size_t g, std::size_t k) {
    if (k != arm) return;
    const double one = variance_at(experiment, number_at(request, a, g, arm));
    const double two = variance_at(experiment, number_at(request, a, g, other));
    if (std::isnan(one) || std::isnan(two)) return;
    ++result.cells;
    result.lower += one < two ? 1 : 0;
  });
  return result;
}

json sweep_summary(const json& experiment) {
  json summary{{"study", "experiment"}, {"comparisons", json::array()}};
  for (const char* key :
       {"t_begun_ns", "request", "bench", "references", "cells_total", "cells_done", "cells"}) {
    summary[key] = experiment[key];
  }
  const json& arms = experiment["request"]["arms"];
  for (std::size_t i = 0; i < arms.size(); ++i) {
    for (std::size_t k = i + 1; k < arms.size(); ++k) {
      const Comparison found = compare_arms(experiment, i, k);
      summary["comparisons"].push_back({{"arm", arm_name(arms[i])},
                                        {"other", arm_name(arms[k])},
                                        {"cells", found.cells},
                                        {"lower", found.lower}});
    }
  }
  return summary;
}

}  // namespace ovws::study
