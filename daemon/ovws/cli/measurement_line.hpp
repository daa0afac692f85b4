/// What an image file told, as a line for a program and as a table for a person.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ovws/cli/measurement.hpp"
#include "daemon/ovws/cli/refined.hpp"

namespace ovws::cli {

/// A line of the form of the `wavefront` message; what only a camera knows is null.
nlohmann::json line_of(const std::string& file, const Config& config,
                       const Measurement& measurement, const Measured& measured);

/// The coefficients of all pixels instead of those of the spots' positions; null if there is a
/// `doubt`, which is told.
void put_refined(nlohmann::json& line, const RefinedModes& found, const std::vector<int>& modes_j,
                 const std::optional<std::string>& doubt);

/// On standard output.
void print_table(const nlohmann::json& line);

}  // namespace ovws::cli
