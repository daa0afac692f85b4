#include "daemon/web/options.hpp"

#include "proto/endpoint.hpp"

namespace ovws::web {
namespace {

std::string without_brackets(const std::string& address) {
  return address.starts_with('[') ? address.substr(1, address.size() - 2) : address;
}

}  // namespace

std::vector<std::string> Options::hosts() const {
  std::vector<std::string> hosts{listen, "localhost:" + std::to_string(port)};
  hosts.insert(hosts.end(), more_hosts.begin(), more_hosts.end());
  return hosts;
}

Result<void> check_options(Options& options) {
  const std::string endpoint = "tcp://" + options.listen;
  if (bind_fault(endpoint)) {
    return fail(Errc::invalid, "--listen",
                "must be ADDRESS:PORT, a numeric address and a port from 1 to 65535, e.g. "
                "127.0.0.1:7704");
  }
  const auto colon = options.listen.rfind(':');
  const std::string address = options.listen.substr(0, colon);
  if (!is_reached_from_here_only(endpoint) && !options.cleartext) {
    return fail(Errc::invalid, "--listen",
                address +
                    " is reachable from other machines, and others on the network could read the "
                    "page's token: listen on 127.0.0.1 and use ssh -L or a TLS proxy "
                    "(--allow-host), or accept it with --cleartext");
  }
  options.address = without_brackets(address);
  options.port = static_cast<unsigned short>(std::stoi(options.listen.substr(colon + 1)));
  return {};
}

}  // namespace ovws::web
