/// Field tables of `system.describe` and `config.save`.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "proto/field_json.hpp"

namespace ovws {

/// Result of `config.save`.
struct SavedReport {
  std::string path;
  std::vector<std::string> saved;
};
template <>
struct Table<SavedReport> {
  static constexpr const char* kName = "SavedReport";
  static constexpr auto kFields = Fields{
      field("path", &SavedReport::path,
            "path of the overlay file in the state directory; the file does not exist if saved is "
            "empty"),
      field("saved", &SavedReport::saved,
            "dotted keys of the values that differ from the configuration file, sorted")};
};

/// Role of a client: the methods that it may call. Every client may subscribe to the streams.
enum class Role {
  read,     ///< read-only methods
  control,  ///< all methods
};
template <>
struct Names<Role> {
  static const std::vector<std::string>& all() {
    static const std::vector<std::string> names{"read", "control"};
    return names;
  }
};

struct MethodDescription {
  std::string title, description;
  Json params, result;
};
template <>
struct Table<MethodDescription> {
  using M = MethodDescription;
  static constexpr const char* kName = "MethodDescription";
  static constexpr auto kFields =
      Fields{field("title", &M::title, "short title"),
             field("description", &M::description, "what the method does"),
             field("params", &M::params, "JSON Schema of the params"),
             field("result", &M::result, "JSON Schema of the result")};
};

/// Result of `system.describe`.
struct Description {
  std::vector<std::pair<std::string, std::string>> versions;
  std::vector<std::pair<std::string, MethodDescription>> methods;
  std::vector<std::pair<std::string, Role>> roles;
  std::vector<std::pair<std::string, Json>> streams;
};
template <>
struct Table<Description> {
  using D = Description;
  static constexpr const char* kName = "Description";
  static constexpr auto kFields =
      Fields{field("versions", &D::versions, "versions of the daemon and its libraries"),
             field("methods", &D::methods, "methods by name"),
             field("roles", &D::roles,
                   "role that a client needs to call each method, by name; checked only if "
                   "clients need keys"),
             field("streams", &D::streams, "JSON Schema of each topic's JSON part")};
};

}  // namespace ovws
