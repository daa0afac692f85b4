/// Resolves the configured `camera.id` to an opened Aravis device.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "drivers/aravis/gerror.hpp"

namespace ovws {

struct FoundDevice {
  GRef<ArvDevice> device;
  std::string address;  ///< IP address, or name of the USB device
};

/// Always opens by address. An IP address is used directly; an Aravis device id or serial number is
/// looked up first, which takes about 1 s. Errc::unavailable, field "camera.id", if nothing answers
/// (with a list of the cameras found) or another program controls the camera; both take at most
/// about 6 s. Errc::invalid if `id` is empty.
Result<FoundDevice> find_device(const std::string& id);

}  // namespace ovws
