/// The methods and streams of a daemon in words.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ovws::cli {

/// List of all methods and streams, grouped by the first part of their names, one line each.
/// `description`: result of system.describe. The descriptions begin in column kDescriptionColumn.
std::string list_text(const nlohmann::json& description);
inline constexpr std::size_t kDescriptionColumn = 22;

/// One method: its keys with ranges and defaults, an example, and the keys of its result. Or one
/// stream: the keys of its messages. `name`: "camera.set", or "wavefront" or "stream.wavefront" for
/// a stream. Empty: there is none.
std::string entry_text(const nlohmann::json& description, const std::string& name);
/// The JSON behind it; null: there is none.
nlohmann::json entry_of(const nlohmann::json& description, const std::string& name);
/// All names that entry_text accepts.
std::vector<std::string> entry_names(const nlohmann::json& description);

/// Params as words of `ovws call`, the inverse of params_of; lists of other things as JSON in
/// single quotes.
std::string words_of_params(const nlohmann::json& params);

}  // namespace ovws::cli
