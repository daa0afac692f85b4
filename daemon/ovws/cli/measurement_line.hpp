/// Output of an image file's measurement: a JSON object or a table.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ovws/cli/measurement.hpp"

namespace ovws::cli {

/// A JSON object like the `wavefront` message; fields that only a camera provides are null.
nlohmann::json line_of(const std::string& file, const Config& config,
                       const Measurement& measurement, const Measured& measured);

/// Adds what a known camera tells. An image that is not explained has no coefficients, and
/// `refined.reason` says why.
void put_refined(nlohmann::json& line, const Measured& measured, bool amplitudes);

/// Prints the measurement as a table on standard output.
void print_table(const nlohmann::json& line);

}  // namespace ovws::cli
