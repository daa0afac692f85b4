/// The JSON Schemas of proto/schema, as they were at build time.
#pragma once

#include <span>
#include <string_view>

namespace ovws {

struct SchemaFile {
  std::string_view name;  ///< "camera.set", "stream.wavefront"
  std::string_view text;
};

/// All, sorted by name.
std::span<const SchemaFile> schemas();
/// Empty if there is none of that name.
std::string_view schema_text(std::string_view name);

}  // namespace ovws
