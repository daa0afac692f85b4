#include "daemon/ovwsd/control/method_table.hpp"

#include <algorithm>

#include "core/rt/counters.hpp"
#include "daemon/ovwsd/access/client_guard.hpp"
#include "proto/reader.hpp"

namespace ovws {
namespace {

std::vector<const MethodRow*> all_methods() {
  std::vector<const MethodRow*> all;
  for (const auto& table : {camera_methods(), corrector_methods(), sensor_methods(),
                            reference_methods(), system_methods(), lattice_methods()}) {
    for (const MethodRow& method : table) all.push_back(&method);
  }
  return all;
}

RpcFailure unknown_method(const std::string& name) {
  RpcFailure failure{
      RpcCode::method,
      "there is no method \"" + name + "\"",
      {{"field", "method"}, {"reason", "unknown; system.describe lists all methods"}}};
  std::vector<std::string> names;
  for (const MethodRow* const method : all_methods()) names.emplace_back(method->name);
  if (const auto nearest = nearest_name(name, names)) {
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

std::vector<std::pair<std::string, Role>> method_roles() {
  std::vector<std::pair<std::string, Role>> roles;
  for (const MethodRow* const method : all_methods()) {
    roles.emplace_back(method->name, method->role);
  }
  return roles;
}

void dispatch(Services& services, const std::string& key, RpcCall call, RpcReply reply) {
  services.counters.add(Counter::requests);
  auto counted = [&counters = services.counters, reply = std::move(reply)](RpcAnswer answer) {
    if (!answer) counters.add(Counter::requests_refused);
    reply(std::move(answer));
  };
  const auto role = services.clients.role_of(key);
  if (!role) return counted(forbidden("", role.error().reason));
  static const std::vector<const MethodRow*> kAll = all_methods();
  const auto at = std::find_if(kAll.begin(), kAll.end(),
                               [&](const MethodRow* one) { return call.method == one->name; });
  if (at == kAll.end()) return counted(tl::make_unexpected(unknown_method(call.method)));
  const MethodRow& found = **at;
  if (found.role == Role::control && *role == Role::read) {
    return counted(forbidden("method", call.method +
                                           " needs the role \"control\"; the role of this "
                                           "client in security.clients is \"read\""));
  }
  found.call(found, services, std::move(call), std::move(counted));
}

}  // namespace ovws
