/// Camera link: the network interface or USB port between this machine and a camera.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

struct NetworkPath {
  std::string interface;         ///< name of the network interface: "eth1"
  std::string own_address;       ///< this machine's IPv4 address on the interface
  int mtu_bytes = 0;             ///< largest IP packet of the interface; 0: unknown
  std::optional<int> link_mbps;  ///< link speed, Mbit/s; none: unknown, e.g. a virtual interface
  bool same_network = false;     ///< interface and camera are in one subnet, without a router
};

/// Finds the network interface on the route to an IPv4 address; sends no packets. Errors, field
/// "camera.id": Errc::invalid (not an IPv4 address), Errc::unavailable (no interface leads to it).
Result<NetworkPath> path_to(const std::string& address);

/// Negotiated USB speed of the device with this serial number, Mbit/s; none if sysfs lists no such
/// device.
std::optional<int> usb_link_mbps(const std::string& serial);

}  // namespace ovws
