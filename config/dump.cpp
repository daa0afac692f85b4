/// Serialises Config to JSON, with the keys in the order of ovwsd.json.
#include <cmath>

#include "config/tables.hpp"

namespace ovws {

std::string dump_config(const Config& config) {
  Config written = config;
  // NaN (a camera without gain in dB) becomes 0, because a gain of 0 leaves this camera unchanged.
  double& gain_db = written.camera.settings.gain_db;
  if (std::isnan(gain_db)) gain_db = 0.0;
  // parse_config and registration.run give a fixed array its lenslets.
  if (config.modulator == Modulator::fixed) written.sensor.lenslets = {};
  using nlohmann::ordered_json;
  return to_json<ordered_json>(written).dump(2, ' ', false,
                                             ordered_json::error_handler_t::replace) +
         "\n";
}

}  // namespace ovws
