#include "daemon/ovwsd/access/client_guard.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/control/status_reporter.hpp"
#include "daemon/ovwsd/devices/versions.hpp"
#include "daemon/shared/schemas/schemas.hpp"
#include "proto/tables/description.hpp"
#include "proto/tables/status.hpp"

namespace ovws {
namespace {

Json make_description() {
  Description all;
  all.versions = versions();
  all.roles = method_roles();
  constexpr std::string_view kStream = "stream.";
  for (const Schema& one : schemas()) {
    if (one.name.starts_with(kStream)) {
      all.streams.emplace_back(one.name.substr(kStream.size()), one.json);
      continue;
    }
    all.methods.emplace_back(one.name, MethodDescription{one.json["title"], one.json["description"],
                                                         one.json["params"], one.json["result"]});
  }
  return to_json(all);
}

void describe(Services& /*services*/, Reply<Description> reply) {
  static const Json kDescription = make_description();  // it takes milliseconds
  reply(JsonOf<Description>{kDescription});
}

void status(Services& services, Reply<StatusMessage> reply) {
  reply(services.status.current());
}

constexpr std::array kRows{
    row<kSystemDescribe, describe>(Role::read, Action::read),
    row<kSystemStatus, status>(Role::read, Action::read),
};

}  // namespace

std::span<const MethodRow> system_methods() {
  return kRows;
}

}  // namespace ovws
