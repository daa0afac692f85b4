#include "proto/endpoint.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <string>

#include "core/base/number_text.hpp"

namespace ovws {
namespace {

constexpr std::string_view kTcp = "tcp://";
constexpr std::string_view kIpc = "ipc://";
constexpr std::size_t kMaxPath = 107;  // bytes; limit of sockaddr_un

bool is_port(std::string_view text) {
  const auto port = number_from<int>(text);
  return port && *port >= 1 && *port <= 65535;
}

/// Whether the host is "[ADDRESS]", an IPv6 address, which may name its interface
/// ("[fe80::1%eth0]").
bool is_ipv6_host(const std::string& host) {
  if (!host.starts_with('[') || !host.ends_with(']')) return false;
  const std::string address = host.substr(1, std::min(host.find('%'), host.size() - 1) - 1);
  in6_addr parsed{};
  return ::inet_pton(AF_INET6, address.c_str(), &parsed) == 1;
}

}  // namespace

std::string host_of(std::string_view endpoint) {
  const auto colon = endpoint.rfind(':');
  if (!endpoint.starts_with(kTcp) || colon < kTcp.size()) return {};
  return std::string(endpoint.substr(kTcp.size(), colon - kTcp.size()));
}

std::optional<std::string> endpoint_fault(std::string_view endpoint) {
  const std::string is = "\"" + std::string(endpoint.substr(0, 200)) + "\" is not an endpoint: ";
  if (endpoint.rfind(kIpc, 0) == 0) {
    const auto path = endpoint.substr(kIpc.size());
    if (path == "*") return is + "give the path";
    if (!path.empty() && path.size() <= kMaxPath) return std::nullopt;
    return is + "the path must have 1 to " + std::to_string(kMaxPath) + " bytes";
  }
  if (endpoint.rfind(kTcp, 0) != 0) return is + "it must be tcp://ADDRESS:PORT or ipc://PATH";
  const auto address = endpoint.substr(kTcp.size());
  const auto colon = address.rfind(':');
  if (colon == std::string_view::npos || colon == 0 || !is_port(address.substr(colon + 1))) {
    return is + "it must end with :PORT, from 1 to 65535";
  }
  const std::string host = host_of(endpoint);
  if (host.find_first_of("[]:") != std::string::npos && !is_ipv6_host(host)) {
    return is + "an IPv6 address is written in brackets, e.g. tcp://[::1]:7702";
  }
  return std::nullopt;
}

std::optional<std::string> bind_fault(std::string_view endpoint) {
  if (auto fault = endpoint_fault(endpoint)) return fault;
  if (host_of(endpoint) != "localhost") return std::nullopt;
  return "\"" + std::string(endpoint) + "\" is a name: give the address, tcp://127.0.0.1" +
         std::string(endpoint.substr(endpoint.rfind(':')));
}

bool is_ipv6(std::string_view endpoint) {
  return is_ipv6_host(host_of(endpoint));
}

bool is_reached_from_here_only(std::string_view endpoint) {
  if (endpoint.starts_with(kIpc)) return !endpoint.substr(kIpc.size()).starts_with('@');
  const std::string host = host_of(endpoint);
  in_addr address{};
  if (::inet_pton(AF_INET, host.c_str(), &address) == 1) return ntohl(address.s_addr) >> 24 == 127;
  return host == "[::1]";
}

std::string local_endpoint(std::string_view endpoint) {
  const std::string host = host_of(endpoint);
  const bool is_any = host == "*" || host == "0.0.0.0";
  if (!is_any && host != "[::]") return std::string(endpoint);
  const std::string port(endpoint.substr(endpoint.rfind(':')));
  return (is_any ? "tcp://127.0.0.1" : "tcp://[::1]") + port;
}

}  // namespace ovws
