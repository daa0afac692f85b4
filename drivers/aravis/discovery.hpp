/// From what a person writes into the configuration to an opened Aravis device.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "drivers/aravis/gerror.hpp"

namespace ovws {

struct FoundDevice {
  GRef<ArvDevice> device;
  std::string address;  ///< IP address, or USB's own name of the device
};

/// Opens by address, always: an IP address is asked directly; an Aravis device id or a serial
/// number is looked up first, which takes about 1 s. Errc::unavailable, field "camera.id", if
/// nothing answers there (with a list of what was found) or another program controls it; at most
/// about 6 s, both for an address that is silent and for a camera in other hands.
Result<FoundDevice> find_device(const std::string& id);

}  // namespace ovws
