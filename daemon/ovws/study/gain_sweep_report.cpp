#include "daemon/ovws/study/gain_sweep_report.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/optics/zernike.hpp"
#include "proto/json_text.hpp"

namespace ovws::study {
namespace {

using nlohmann::json;

constexpr std::array<const char*, 20> kColumns{"cell",
                                               "charge",
                                               "tracker",
                                               "aberration",
                                               "gain_db",
                                               "frames",
                                               "variance_rad2",
                                               "standard_deviation_rad2",
                                               "standard_error_rad2",
                                               "unsaturated_variance_rad2",
                                               "undetermined_frames",
                                               "saturated_frames",
                                               "lost_spots",
                                               "level_dn",
                                               "noise_dn",
                                               "peak_dn",
                                               "exposure_us",
                                               "frame_rate_hz",
                                               "t_begun_ns",
                                               "arm"};

std::string text_of(const json& value) {
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : json_text(value);
}

double number_of(const json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
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
  return fmt::format("{}\n", fmt::join(kColumns, ","));
}

std::string cells_csv_row(const json& cell) {
  std::vector<std::string> values;
  for (const char* key : kColumns) values.push_back(text_of(cell[key]));
  return fmt::format("{}\n", fmt::join(values, ","));
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
