/// Params of a method from the words of a command line, and the JSON Schema behind them in words.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/result.hpp"

namespace ovws::cli {

/// A key of a method's params. Keys of nested objects have their path: "roi.width".
struct ParamsKey {
  std::string path;
  nlohmann::json schema;  ///< without $ref
  bool required = false;
};

/// The schema of params of an unknown method: any keys, whose values are JSON or else text.
const nlohmann::json& any_params();

/// All keys of a params schema, sorted. A list of modes, which also accepts LIST.MODE, is one key.
std::vector<ParamsKey> keys_of(const nlohmann::json& params_schema);
/// Whether a key is a list of objects that each have a mode (j) and one number, e.g. `modes` of
/// aberration.set. Then the word LIST.MODE=NUMBER sets one in the list.
bool is_mode_list(const nlohmann::json& schema);
/// What a value must be: "a number from 0.1 to 60000000", "one of rms, unit".
std::string expected_of(const nlohmann::json& schema);

/// Params from words. Each word is one of:
///
///     roi.width=512             dots nest; the value is text, or JSON if the schema requires
///                               another type; a list may be written as 3,4,5
///     modes.vertical-coma=0.2   sets a mode in a list of modes, see mode_of
///     {"gain_db": 12}           a JSON object
///     @FILE, -                  a JSON object from a file, or from standard input
///
/// Later words override earlier ones. Ranges are left to the daemon. Errors (Errc::invalid) name
/// the key, the nearest key or value, and what is allowed.
Result<nlohmann::json> params_of(const nlohmann::json& params_schema,
                                 const std::vector<std::string>& words);

}  // namespace ovws::cli
