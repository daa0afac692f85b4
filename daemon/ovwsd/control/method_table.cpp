#include "daemon/ovwsd/control/method_table.hpp"

#include "core/rt/counters.hpp"
#include "daemon/ovwsd/access/client_guard.hpp"
#include "proto/reader.hpp"

namespace ovws {
namespace {

std::array<std::span<const MethodRow>, 17> all_methods() {
  return {system_methods(),       camera_methods(),      sensor_methods(),    aberration_methods(),
          correction_methods(),   loop_methods(),        reference_methods(), job_methods(),
          registration_methods(), calibration_methods(), lut_methods(),       flatness_methods(),
          slm_methods(),          refine_methods(),      record_methods(),    config_methods(),
          experiment_methods()};
}

const MethodRow* find_method(const std::string& name) {
  for (const auto& table : all_methods()) {
    for (const MethodRow& method : table) {
      if (name == method.name) return &method;
    }
  }
  return nullptr;
}

RpcFailure unknown_method(const std::string& name) {
  RpcFailure failure{
      RpcCode::method,
      "there is no method \"" + name + "\"",
      {{"field", "method"}, {"reason", "unknown; system.describe lists all methods"}}};
  if (const auto nearest = nearest_name(name, method_names())) {
    failure.message += ", did you mean \"" + *nearest + "\"?";
    failure.data["nearest"] = *nearest;
  }
  return failure;
}

RpcAnswer forbidden(const std::string& field, const std::string& reason) {
  return tl::make_unexpected(
      RpcFailure{RpcCode::forbidden, reason, {{"field", field}, {"reason", reason}}});
}

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const auto& table : all_methods()) {
    for (const MethodRow& method : table) names.emplace_back(method.name);
  }
  return names;
}

std::vector<std::pair<std::string, Role>> method_roles() {
  std::vector<std::pair<std::string, Role>> roles;
  for (const auto& table : all_methods()) {
    for (const MethodRow& method : table) {
      roles.emplace_back(method.name, method.role);
    }
  }
  return roles;
}

void dispatch(Services& services, const std::string& key, const std::string& method,
              const nlohmann::json& params, RpcReply reply) {
  services.counters.add(Counter::requests);
  auto counted = [&counters = services.counters, reply = std::move(reply)](RpcAnswer answer) {
    if (!answer) counters.add(Counter::requests_refused);
    reply(std::move(answer));
  };
  const auto role = services.clients.role_of(key);
  if (!role) return counted(forbidden("", role.error().reason));
  const MethodRow* const found = find_method(method);
  if (found == nullptr) return counted(tl::make_unexpected(unknown_method(method)));
  if (found->role == Role::control && *role == Role::read) {
    return counted(forbidden("method", method + " needs the role \"control\"; the role of this "
                                                "client in security.clients is \"read\""));
  }
  found->call(*found, services, params, std::move(counted));
}

}  // namespace ovws
