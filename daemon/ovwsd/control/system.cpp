#include "daemon/ovwsd/control/methods.hpp"
#include "daemon/ovwsd/devices/versions.hpp"
#include "proto/encode.hpp"
#include "proto/schemas.hpp"

namespace ovws {
namespace {

/// Every method and every stream with its JSON Schema, and the versions of what is running.
nlohmann::json make_description() {
  nlohmann::json methods = nlohmann::json::object();
  for (const std::string& name : method_names()) {
    methods[name] = nlohmann::json::parse(schema_text(name), nullptr, false);
  }
  nlohmann::json roles = nlohmann::json::object();
  for (const auto& [name, role] : method_roles()) roles[name] = role;
  nlohmann::json streams = nlohmann::json::object();
  constexpr std::string_view kStreamPrefix = "stream.";
  for (const SchemaFile& schema : schemas()) {
    if (!schema.name.starts_with(kStreamPrefix)) continue;
    streams[std::string(schema.name.substr(kStreamPrefix.size()))] =
        nlohmann::json::parse(schema.text, nullptr, false);
  }
  nlohmann::json running = nlohmann::json::object();
  for (const auto& [name, version] : versions()) running[name] = version;
  return {{"methods", std::move(methods)},
          {"roles", std::move(roles)},
          {"streams", std::move(streams)},
          {"versions", std::move(running)}};
}

/// Made once: parsing the schemas takes milliseconds.
void describe(Services& /*services*/, const nlohmann::json& /*params*/, RpcReply reply) {
  static const nlohmann::json kDescription = make_description();
  reply(nlohmann::json(kDescription));
}

void status(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(to_json(services.status.current()));
}

constexpr std::array<Method, 2> kMethods{{
    {"system.describe", Role::read, Action::read, describe},
    {"system.status", Role::read, Action::read, status},
}};

}  // namespace

std::span<const Method> system_methods() {
  return kMethods;
}

}  // namespace ovws
