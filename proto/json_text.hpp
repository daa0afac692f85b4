/// JSON to text and back, apart from nlohmann's header, whose parser and serialiser take seconds to
/// compile. config/dump.cpp and daemon/shared/key_file.cpp keep the order of their keys instead.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace ovws {

/// One line, or with `indent` >= 0 a line for each value. Never throws: bytes that are not UTF-8,
/// which texts of a device or client may contain, are replaced.
std::string json_text(const nlohmann::json& value, int indent = -1);

/// For requests and configurations, which need an error with a place, see parse_strict_json. If the
/// text is not JSON, the result is_discarded(): at(), [], value() and get() of it throw
/// nlohmann::json::type_error.
nlohmann::json json_of(std::string_view text);

}  // namespace ovws
