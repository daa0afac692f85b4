#include "daemon/handlers/methods.hpp"
#include "daemon/store/atomic_file.hpp"

namespace ovws {
namespace {

/// The configuration that a restart would need to come back as things are now.
Config effective(const Services& services) {
  Config config = services.config;
  const SensorSnapshot sensor = services.instrument.snapshot();
  config.camera.settings = services.camera.snapshot().settings;
  config.sensor = sensor.sensor;
  config.tracking = sensor.tracking;
  config.refine = in_format(services.refiner.settings(), config.camera.settings.pixel_format);
  return config;
}

void get(Services& services, const nlohmann::json& params, RpcReply reply) {
  if (const auto nothing = decode_nothing(params); !nothing) return reply(failed(nothing.error()));
  reply(nlohmann::json::parse(dump_config(effective(services)), nullptr, false));
}

void save(Services& services, const nlohmann::json& params, RpcReply reply) {
  if (const auto nothing = decode_nothing(params); !nothing) return reply(failed(nothing.error()));
  if (services.config_path.empty()) {
    return reply(failed({Errc::refused, "",
                         "the daemon was started without a configuration file: start it with "
                         "--config FILE"}));
  }
  const auto saved = replace_file(services.config_path, dump_config(effective(services)));
  if (!saved) return reply(failed(saved.error()));
  reply(nlohmann::json{{"path", services.config_path}});
}

constexpr std::array<Method, 2> kMethods{{
    {"config.get", Action::read, get},
    {"config.save", Action::save_config, save},
}};

}  // namespace

std::span<const Method> config_methods() {
  return kMethods;
}

}  // namespace ovws
