#include "proto/endpoint.hpp"

#include <arpa/inet.h>

#include <charconv>
#include <string>

namespace ovws {
namespace {

constexpr std::string_view kTcp = "tcp://";
constexpr std::string_view kIpc = "ipc://";
constexpr std::size_t kMaxPath = 107;  // bytes; limit of sockaddr_un

bool is_port(std::string_view text) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port >= 1 && port <= 65535;
}

}  // namespace

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
  return std::nullopt;
}

bool is_reached_from_here_only(std::string_view endpoint) {
  if (endpoint.starts_with(kIpc)) return !endpoint.substr(kIpc.size()).starts_with('@');
  if (!endpoint.starts_with(kTcp)) return false;
  const std::string host(endpoint.substr(kTcp.size(), endpoint.rfind(':') - kTcp.size()));
  in_addr address{};
  if (::inet_pton(AF_INET, host.c_str(), &address) == 1) return ntohl(address.s_addr) >> 24 == 127;
  return host == "[::1]";
}

std::string local_endpoint(std::string_view endpoint) {
  const auto colon = endpoint.rfind(':');
  if (!endpoint.starts_with(kTcp) || colon < kTcp.size()) return std::string(endpoint);
  const auto host = endpoint.substr(kTcp.size(), colon - kTcp.size());
  const std::string port(endpoint.substr(colon));
  if (host == "*" || host == "0.0.0.0") return "tcp://127.0.0.1" + port;
  return host == "[::]" ? "tcp://[::1]" + port : std::string(endpoint);
}

}  // namespace ovws
