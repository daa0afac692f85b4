/// Strict parser for untrusted JSON text: never throws, and reports what is wrong and where.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/base/result.hpp"

namespace ovws {

struct JsonFault {
  bool malformed = true;  ///< false: valid JSON, but refused
  std::string reason;
};

enum class JsonComments { refused, allowed };

/// Parses RFC 8259 JSON in strict UTF-8. Also refuses duplicate keys in one object, and nesting
/// deeper than `max_depth`, so that the result can be copied, written and destroyed recursively.
/// Reentrant.
tl::expected<nlohmann::json, JsonFault> parse_strict_json(std::string_view text, int max_depth,
                                                          JsonComments comments);

/// Reads a file of settings. Errc::unavailable: it does not exist; Errc::invalid: it is larger than
/// 1 MiB, or cannot be read. The reason does not name the file.
Result<std::string> read_small_file(const std::string& path);

}  // namespace ovws
