#include "config/config.hpp"
#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/config_difference.hpp"
#include "daemon/ovwsd/settings/config_in_use.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/ovwsd/streams/image_publisher.hpp"
#include "proto/json_text.hpp"
#include "proto/tables/description.hpp"

namespace ovws {
namespace {

Config in_use(const Services& services) {
  return config_in_use(services.config, services.loaded.get(), services.camera, services.keeper,
                       services.refiner);
}

void get(Services& services, Reply<Config> reply) {
  // In the format of the file: 0 for a gain in dB that the camera does not have.
  reply(JsonOf<Config>{json_of(dump_config(in_use(services)))});
}

void save(Services& services, Reply<SavedReport> reply) {
  const LoadedConfig loaded = services.loaded.get();
  if (!loaded.overlay) {
    return reply(Error{Errc::refused, "state.directory",
                       "there is no folder to save to: set state.directory in the configuration "
                       "file, or $STATE_DIRECTORY, and restart the daemon"});
  }
  Config now = in_use(services);
  now.camera.settings = as_in_file(now.camera.settings, services.camera.snapshot().asked,
                                   loaded.file.camera.settings);
  const auto asked =
      services.disk.request([path = *loaded.overlay, values = values_to_save(loaded, now), reply] {
        const auto saved = write_saved(path, values);
        if (!saved) return reply(saved.error());
        reply(SavedReport{path, values.keys});
      });
  if (!asked) reply(asked.error());
}

constexpr std::array kRows{
    row<kConfigGet, get>(Role::read, Action::read),
    row<kConfigSave, save>(Role::control, Action::save_config),
};

}  // namespace

std::span<const MethodRow> config_methods() {
  return kRows;
}

}  // namespace ovws
