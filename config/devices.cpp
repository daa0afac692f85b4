#include "config/devices.hpp"

#include <stdexcept>
#include <string_view>

#include "config/device_tables.hpp"
#include "proto/strict_json.hpp"

namespace ovws {

extern const std::string_view kDevicesJson;  // generated from devices.json

const Devices& known_devices() {
  static const Devices devices = [] {
    const auto json = parse_strict_json(kDevicesJson, 8, JsonComments::allowed);
    if (!json) throw std::logic_error("devices.json: " + json.error().reason);
    auto read = decode<Devices>(*json);
    if (!read) throw std::logic_error("devices.json: " + text_of(read.error()));
    return std::move(*read);
  }();
  return devices;
}

}  // namespace ovws
