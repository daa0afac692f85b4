/// What people see of a stream's message: tables of modes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace ovws::cli {

/// Whether the topic's messages have a table.
bool has_table(const std::string& topic);
/// `referenced`: whether the sensor has a reference; `pattern`: what the SLM shows. They say why a
/// message is not valid.
void print_wavefront(const nlohmann::json& message, const nlohmann::json& status);
void print_refined(const nlohmann::json& message);

}  // namespace ovws::cli
