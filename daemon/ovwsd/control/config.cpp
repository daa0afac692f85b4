#include "daemon/ovwsd/control/methods.hpp"
#include "daemon/ovwsd/settings/config_difference.hpp"
#include "daemon/ovwsd/settings/config_in_use.hpp"

namespace ovws {
namespace {

Config in_use(const Services& services) {
  return config_in_use(services.config, services.loaded.get(), services.camera, services.instrument,
                       services.refiner);
}

void get(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(nlohmann::json::parse(dump_config(in_use(services)), nullptr, false));
}

void save(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  const LoadedConfig loaded = services.loaded.get();
  if (!loaded.overlay) {
    return reply(failed({Errc::refused, "state.directory",
                         "there is no folder to save to: set state.directory in the configuration "
                         "file, or $STATE_DIRECTORY, and restart the daemon"}));
  }
  Config now = in_use(services);
  now.camera.settings = as_in_file(now.camera.settings, services.camera.snapshot().asked,
                                   loaded.file.camera.settings);
  const auto asked =
      services.disk.request([path = *loaded.overlay, values = values_to_save(loaded, now), reply] {
        const auto saved = write_saved(path, values);
        if (!saved) return reply(failed(saved.error()));
        reply(nlohmann::json{{"path", path}, {"saved", values.keys}});
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
