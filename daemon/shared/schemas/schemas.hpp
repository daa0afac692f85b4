/// The JSON Schemas of every method and stream, made from the field tables.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace ovws {

struct Schema {
  std::string name;  ///< "camera.set", "stream.wavefront"
  /// Of a method: {title, description, params, result}, the last two JSON Schemas; of a stream: the
  /// JSON Schema of its messages' JSON part. All have examples.
  nlohmann::json json;
};

/// All, sorted by name. Made at the first call, which takes milliseconds. Any thread.
const std::vector<Schema>& schemas();
/// Null if there is none of that name.
const nlohmann::json& schema(std::string_view name);

}  // namespace ovws
