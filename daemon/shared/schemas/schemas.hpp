/// JSON Schemas of every method and stream, generated from the field tables.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace ovws {

struct Schema {
  std::string name;  ///< "camera.set", "stream.wavefront"
  /// For a method: {title, description, params, result}, where `params` and `result` are JSON
  /// Schemas, and the meanings of its binary frames, binary_params and binary_result. For a stream:
  /// the JSON Schema of its messages' JSON part. All schemas have examples.
  nlohmann::json json;
};

/// All schemas, sorted by name. The first call builds them within milliseconds. Thread-safe.
const std::vector<Schema>& schemas();
/// The schema of this name; null if it does not exist.
const nlohmann::json& schema(std::string_view name);

}  // namespace ovws
