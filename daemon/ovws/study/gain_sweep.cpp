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

/// e.g. "oblique astigmatism, 0.204 wave RMS (0.5 unit amplitude)".
std::string aberration_name(const ModesSet& aberration) {
  std::string text;
  for (const auto& [j, waves] : aberration.modes) {
    text += fmt::format("{}{}, {:.3f} wave RMS ({:.3g} unit amplitude)", text.empty() ? "" : "; ",
                        zernike_name(j), waves, waves * zernike_rms_factor(j));
  }
  return text.empty() ? "no aberration" : text;
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

std::string arm_name(const SweepArm& arm) {
  return fmt::format("charge {}, {}", arm.charge, to_json(arm.tracker).get<std::string>());
}

std::string sweep_table(const GainSweep& sweep, const SweepCells& cells) {
  std::string text =
      "Mean residual variance, rad^2; * some frames saturated; - no frame with modes\n";
  for (const auto& [number, cell] : cells) {
    const auto [arm, aberration, gain] = sweep.cell(std::size_t(number));
    if (gain == 0 && arm == 0) {
      text += fmt::format("\n{}\n{:>8}", aberration_name(sweep.aberrations[aberration]), "gain/dB");
      for (const SweepArm& one : sweep.arms) text += fmt::format("  {:>24}", arm_name(one));
      text += "\n";
    }
    if (arm == 0) text += fmt::format("{:>8g}", sweep.gains_db[gain]);
    std::string entry = "-";
    if (cell.at("variance_rad2").is_number()) {
      entry = fmt::format("{:.3g} +- {:.1g}{}", number_of(cell.at("variance_rad2")),
                          number_of(cell.at("standard_error_rad2")),
                          cell.at("saturated_frames").get<int>() > 0 ? "*" : " ");
    }
    text += fmt::format("  {:>24}", entry);
    if (arm + 1 == sweep.arms.size()) text += "\n";
  }
  return text;
}

std::vector<Figure> sweep_figures(const GainSweep& sweep, const SweepCells& cells) {
  std::vector<Figure> figures;
  for (const ModesSet& aberration : sweep.aberrations) {
    Figure& figure = figures.emplace_back(Figure{
        fmt::format("experiment-variance-{}", figures.size() + 1), aberration_name(aberration),
        "camera gain (dB)", "mean residual phase variance (rad^2)"});
    figure.log_y = true;
    for (const SweepArm& arm : sweep.arms) figure.series.push_back({arm_name(arm), {}, {}, {}});
  }
  for (const auto& [number, cell] : cells) {
    const auto [arm, aberration, gain] = sweep.cell(std::size_t(number));
    Series& series = figures[aberration].series[arm];
    series.add(sweep.gains_db[gain], number_of(cell.at("variance_rad2")));
    const double error = number_of(cell.at("standard_error_rad2"));
    series.error.push_back(std::isfinite(error) ? error : 0.0);
  }
  return figures;
}

json sweep_comparisons(const GainSweep& sweep, const SweepCells& cells) {
  json all = json::array();
  for (std::size_t i = 0; i < sweep.arms.size(); ++i) {
    for (std::size_t k = i + 1; k < sweep.arms.size(); ++k) {
      int measured = 0, lower = 0;
      for (const auto& [number, cell] : cells) {
        if (sweep.cell(std::size_t(number)).arm != i) continue;
        const double one = number_of(cell.at("variance_rad2"));
        const double two = number_of(cells.at(number + int(k - i)).at("variance_rad2"));
        if (std::isnan(one) || std::isnan(two)) continue;
        ++measured;
        lower += one < two ? 1 : 0;
      }
      all.push_back({{"arm", arm_name(sweep.arms[i])},
                     {"other", arm_name(sweep.arms[k])},
                     {"cells", measured},
                     {"lower", lower}});
    }
  }
  return all;
}

}  // namespace ovws::study
