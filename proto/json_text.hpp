/// JSON serialiser and parser behind plain functions, because nlohmann's full header takes seconds
/// to compile. config/dump.cpp and daemon/shared/key_file.cpp use nlohmann's header, to keep the
/// order of the keys.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace ovws {

/// JSON text of a value, on one line, or with `indent` >= 0 with one line per value. Never throws.
/// Replaces bytes that are not UTF-8, which texts of a device or client may contain.
std::string json_text(const nlohmann::json& value, int indent = -1);

/// Parses JSON text. For requests and configurations use parse_strict_json, which reports the line
/// of an error. If the text is not JSON, the result is_discarded(), and its at(), [], value() and
/// get() throw nlohmann::json::type_error.
nlohmann::json json_of(std::string_view text);

}  // namespace ovws
