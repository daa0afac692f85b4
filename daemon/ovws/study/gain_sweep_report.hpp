/// CSV, table and figures of a gain sweep. `cell`: JSON of a CellReport. `experiment`: an object
/// with the `request`, the `bench`, and the JSON of all references and cells.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ovws/study/figure.hpp"

namespace ovws::study {

/// CSV files; column names contain the units.
std::string cells_csv_header();
std::string cells_csv_row(const nlohmann::json& cell);
std::string frames_csv_header(const nlohmann::json& cell);  ///< last columns: the cell's modes
std::string frames_csv_rows(const nlohmann::json& cell);

/// Name of an arm of the gain sweep, e.g. "charge 1, lg".
std::string arm_name(const nlohmann::json& arm);
/// Name of an element of the request's "aberrations", e.g.
/// "oblique astigmatism, 0.204 wave RMS (0.5 unit amplitude)".
std::string aberration_name(const nlohmann::json& aberration);

/// Table of residual variances: one row per gain, one column per arm.
std::string sweep_table(const nlohmann::json& experiment);
/// Figures of the residual variances, one per aberration.
std::vector<Figure> sweep_figures(const nlohmann::json& experiment);

/// Comparison of two arms: the number of cells that both arms measured, and the number of cells in
/// which the first arm's variance is lower.
struct Comparison {
  int cells = 0, lower = 0;
};
Comparison compare_arms(const nlohmann::json& experiment, std::size_t arm, std::size_t other);

/// JSON summary of the sweep: the experiment, and a comparison of each pair of arms.
nlohmann::json sweep_summary(const nlohmann::json& experiment);

}  // namespace ovws::study
