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
inline constexpr auto kTable<SavedReport> =
    Fields{"SavedReport",
           field<&SavedReport::path>("path of the overlay file in the state directory; the file "
                                     "does not exist if saved is empty"),
           field<&SavedReport::saved>(
               "dotted keys of the values that differ from the configuration file, sorted")};

/// Role of a client: the methods that it may call. Every client may subscribe to the streams.
enum class Role {
  read,     ///< read-only methods
  control,  ///< all methods
};
template <>
inline constexpr NamesOf kNames<Role> = texts<"read", "control">;

struct MethodDescription {
  std::string title, description;
  Json params, result;
  std::string binary_params, binary_result;
};
template <>
inline constexpr auto kTable<MethodDescription> =
    Fields{"MethodDescription",
           field<&MethodDescription::title>("short title"),
           field<&MethodDescription::description>("what the method does"),
           field<&MethodDescription::params>("JSON Schema of the params"),
           field<&MethodDescription::result>("JSON Schema of the result"),
           field<&MethodDescription::binary_params>(
               "meaning of the binary frame after the request's JSON; left out: it has none")
               .or_left_out(),
           field<&MethodDescription::binary_result>(
               "meaning of the binary frame after the result's JSON; left out: it has none")
               .or_left_out()};

/// Result of `system.describe`.
struct Description {
  std::vector<std::pair<std::string, std::string>> versions;
  std::vector<std::pair<std::string, MethodDescription>> methods;
  std::vector<std::pair<std::string, Role>> roles;
  std::vector<std::pair<std::string, Json>> streams;
};
template <>
inline constexpr auto kTable<Description> = Fields{
    "Description", field<&Description::versions>("versions of the daemon and its libraries"),
    field<&Description::methods>("methods by name"),
    field<&Description::roles>(
        "role that a client needs to call each method, by name; checked only if clients need keys"),
    field<&Description::streams>("JSON Schema of each topic's JSON part")};

}  // namespace ovws
