#include "proto/results.hpp"
#include "proto/schemas.hpp"

namespace ovws {
namespace {

constexpr std::string_view kStreamPrefix = "stream.";

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const SchemaFile& file : schemas()) {
    if (file.name.rfind(kStreamPrefix, 0) != 0) names.emplace_back(file.name);
  }
  return names;
}

nlohmann::json describe_result(const std::vector<std::pair<std::string, std::string>>& versions) {
  nlohmann::json out{{"versions", nlohmann::json::object()},
                     {"methods", nlohmann::json::object()},
                     {"streams", nlohmann::json::object()}};
  for (const auto& [name, version] : versions) out["versions"][name] = version;
  for (const SchemaFile& file : schemas()) {
    const bool stream = file.name.rfind(kStreamPrefix, 0) == 0;
    const auto name = stream ? file.name.substr(kStreamPrefix.size()) : file.name;
    out[stream ? "streams" : "methods"][std::string(name)] = nlohmann::json::parse(file.text);
  }
  return out;
}

}  // namespace ovws
