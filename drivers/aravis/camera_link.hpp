/// What lies between this machine and a camera: the network interface, or the USB port.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

struct NetworkPath {
  std::string interface;         ///< "eth1"
  std::string own_address;       ///< of this machine, on that interface
  int mtu_bytes = 0;             ///< longest IP packet that the interface takes
  std::optional<int> link_mbps;  ///< unknown of virtual interfaces
  bool same_network = false;     ///< the interface is in the camera's network, without a router
};

/// The interface that packets to this IPv4 address leave by. Sends nothing. Errors, field
/// "camera.id": Errc::invalid, it is no IPv4 address; Errc::unavailable, no interface leads there.
Result<NetworkPath> path_to(const std::string& address);

/// What the USB port of the device with this serial number negotiated, Mbit/s; none: it is not
/// among the system's devices.
std::optional<int> usb_link_mbps(const std::string& serial);

}  // namespace ovws
