/// What a daemon measured with experiment.gain_sweep, as files for people: CSV, table, figures.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ovws/study/figure.hpp"

namespace ovws::study {

/// Of results of experiment.cell; the units are in the columns' names.
std::string cells_csv_header();
std::string cells_csv_row(const nlohmann::json& cell);
std::string frames_csv_header(const nlohmann::json& cell);  ///< ends with the cell's modes
std::string frames_csv_rows(const nlohmann::json& cell);

/// "charge 1, lg"
std::string arm_name(const nlohmann::json& arm);
/// "oblique astigmatism, 0.204 wave RMS (0.5 unit amplitude)"; of an element of "aberrations" of a
/// request.
std::string aberration_name(const nlohmann::json& aberration);

/// Of a result of experiment.get: the residual variances, a row a gain, a column an arm.
std::string sweep_table(const nlohmann::json& experiment);
/// The same, one figure an aberration.
std::vector<Figure> sweep_figures(const nlohmann::json& experiment);

/// In how many of the cells that both measured the first arm's variance is below the second's;
/// both counts.
struct Comparison {
  int cells = 0, lower = 0;
};
Comparison compare_arms(const nlohmann::json& experiment, std::size_t arm, std::size_t other);

/// For a program: all of experiment.get but the job, and every two arms compared.
nlohmann::json sweep_summary(const nlohmann::json& experiment);

}  // namespace ovws::study
