/// Prints stream messages as tables of modes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace ovws::cli {

/// Whether the topic's messages have a table.
bool has_table(const std::string& topic);
/// `status`: a result of system.status. Its reference and SLM pattern explain an invalid frame.
void print_wavefront(const nlohmann::json& message, const nlohmann::json& status);
void print_refined(const nlohmann::json& message);

}  // namespace ovws::cli
