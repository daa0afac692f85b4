/// Strict parsing of JSON text from outside: never throws, and says where and what was wrong.
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "core/base/result.hpp"

namespace ovws {

struct JsonFault {
  bool malformed = true;  ///< false: it is JSON, but one that is not accepted
  std::string reason;
};

enum class JsonComments { refused, allowed };

/// RFC 8259 with strict UTF-8. Refuses, besides what is not JSON, a key given twice in one object
/// and nesting deeper than `max_depth`, so that what is returned can be copied, written and
/// destroyed by recursion. Reentrant.
tl::expected<nlohmann::json, JsonFault> parse_strict_json(std::string_view text, int max_depth,
                                                          JsonComments comments);

}  // namespace ovws
