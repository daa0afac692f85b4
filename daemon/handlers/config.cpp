#include "daemon/config_in_use.hpp"
#include "daemon/handlers/methods.hpp"
#include "daemon/store/atomic_file.hpp"

namespace ovws {
namespace {

Config in_use(const Services& services) {
  return config_in_use(services.config_in_force.get(), services.camera, services.instrument,
                       services.refiner);
}

void get(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(nlohmann::json::parse(dump_config(in_use(services)), nullptr, false));
}

void save(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  if (services.config_path.empty()) {
    return reply(failed({Errc::refused, "",
                         "the daemon was started without a configuration file: start it with "
                         "--config FILE"}));
  }
  const auto asked = services.disk.request(
      [path = services.config_path, text = dump_config(in_use(services)), reply] {
        const auto saved = replace_file(path, text);
        if (!saved) return reply(failed(saved.error()));
        reply(nlohmann::json{{"path", path}});
      });
  if (!asked) reply(failed(asked.error()));
}

constexpr std::array<Method, 2> kMethods{{
    {"config.get", Role::read, Action::read, get},
    {"config.save", Role::control, Action::save_config, save},
}};

}  // namespace

std::span<const Method> config_methods() {
  return kMethods;
}

}  // namespace ovws
