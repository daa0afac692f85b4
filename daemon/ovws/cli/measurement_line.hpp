/// Output of an image file's measurement: a JSON object or a table.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ovws/cli/measurement.hpp"
#include "daemon/ovws/cli/refined.hpp"

namespace ovws::cli {

/// A JSON object like the `wavefront` message; fields that only a camera provides are null.
nlohmann::json line_of(const std::string& file, const Config& config,
                       const Measurement& measurement, const Measured& measured);

/// Replaces the coefficients of spot positions by those of the fit to all pixels. With a `doubt`
/// they are null, and `refined.reason` holds it.
void put_refined(nlohmann::json& line, const RefinedModes& found, const std::vector<int>& modes_j,
                 const std::optional<std::string>& doubt);

/// Prints the measurement as a table on standard output.
void print_table(const nlohmann::json& line);

}  // namespace ovws::cli
