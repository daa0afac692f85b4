/// The link between this machine and a camera: network interface or USB port.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

struct NetworkPath {
  std::string interface;         ///< "eth1"
  std::string own_address;       ///< this machine's address on the interface
  int mtu_bytes = 0;             ///< largest IP packet of the interface
  std::optional<int> link_mbps;  ///< none for virtual interfaces
  bool same_network = false;     ///< interface and camera are in one subnet, without a router
};

/// The interface on the route to this IPv4 address. Sends nothing. Errors, field "camera.id":
/// Errc::invalid (not an IPv4 address), Errc::unavailable (no interface leads there).
Result<NetworkPath> path_to(const std::string& address);

/// Negotiated USB speed of the device with this serial number, Mbit/s; none if sysfs lists no such
/// device.
std::optional<int> usb_link_mbps(const std::string& serial);

}  // namespace ovws
