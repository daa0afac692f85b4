#include "drivers/aravis/camera_link.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/ethtool.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "drivers/aravis/udp_socket.hpp"

namespace ovws {

namespace {

struct FreeAddresses {
  void operator()(ifaddrs* list) const { ::freeifaddrs(list); }
};

in_addr_t ipv4_of(const sockaddr* address) {
  return reinterpret_cast<const sockaddr_in*>(address)->sin_addr.s_addr;
}

/// Local address on the route to `there`, found by connecting a UDP socket, which sends nothing.
/// None if there is no route.
std::optional<in_addr> own_address_towards(const UdpSocket& socket, const in_addr& there) {
  constexpr std::uint16_t kAnyPort = 3956;
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kAnyPort);
  to.sin_addr = there;
  sockaddr_in own{};
  socklen_t size = sizeof own;
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0 ||
      ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&own), &size) != 0)
    return std::nullopt;
  return own.sin_addr;
}

ifreq request_for(const std::string& interface) {
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  return request;
}

int mtu_of(const UdpSocket& socket, const std::string& interface) {
  ifreq request = request_for(interface);
  return ::ioctl(socket.get(), SIOCGIFMTU, &request) == 0 ? request.ifr_mtu : 0;
}

std::optional<int> speed_of(const UdpSocket& socket, const std::string& interface) {
  ethtool_cmd link{};
  link.cmd = ETHTOOL_GSET;
  ifreq request = request_for(interface);
  request.ifr_data = reinterpret_cast<char*>(&link);
  if (::ioctl(socket.get(), SIOCETHTOOL, &request) != 0) return std::nullopt;
  const auto mbps = ethtool_cmd_speed(&link);
  constexpr unsigned kUnknownOld = 0xffff;
  if (mbps == 0 || mbps == kUnknownOld || mbps == unsigned(SPEED_UNKNOWN)) return std::nullopt;
  return int(mbps);
}

std::string word_in(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string word;
  file >> word;
  return word;
}

}  // namespace

Result<NetworkPath> path_to(const std::string& address) {
  in_addr there{};
  if (::inet_pton(AF_INET, address.c_str(), &there) != 1)
    return fail(Errc::invalid, "camera.id", address + " is not an IPv4 address");
  const UdpSocket socket;
  const auto own = own_address_towards(socket, there);
  ifaddrs* list = nullptr;
  const bool listed = own && ::getifaddrs(&list) == 0;
  const std::unique_ptr<ifaddrs, FreeAddresses> owner(list);
  for (const ifaddrs* one = listed ? list : nullptr; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET ||
        ipv4_of(one->ifa_addr) != own->s_addr)
      continue;
    const in_addr_t mask = one->ifa_netmask != nullptr ? ipv4_of(one->ifa_netmask) : 0;
    char text[INET_ADDRSTRLEN] = "";
    ::inet_ntop(AF_INET, &*own, text, sizeof text);
    return NetworkPath{one->ifa_name, text, mtu_of(socket, one->ifa_name),
                       speed_of(socket, one->ifa_name),
                       mask != 0 && (own->s_addr & mask) == (there.s_addr & mask)};
  }
  return fail(Errc::unavailable, "camera.id",
              "no network interface of this machine leads to " + address +
                  "; check the address and the network settings");
}

std::optional<int> usb_link_mbps(const std::string& serial) {
  namespace fs = std::filesystem;
  std::error_code failed;
  for (const auto& device : fs::directory_iterator("/sys/bus/usb/devices", failed)) {
    if (serial.empty() || word_in(device.path() / "serial") != serial) continue;
    const int mbps = std::atoi(word_in(device.path() / "speed").c_str());
    if (mbps > 0) return mbps;
  }
  return std::nullopt;
}

}  // namespace ovws
