#include "daemon/web/options.hpp"

#include "proto/endpoint.hpp"

namespace ovws::web {
namespace {

constexpr double kAnswerTimeoutS = 10.0;  ///< a camera may take seconds to change

std::string without_brackets(const std::string& address) {
  return address.starts_with('[') ? address.substr(1, address.size() - 2) : address;
}

}  // namespace

std::vector<std::string> Options::hosts() const {
  std::vector<std::string> hosts{listen, "localhost:" + std::to_string(port)};
  hosts.insert(hosts.end(), more_hosts.begin(), more_hosts.end());
  return hosts;
}

void add_options(CLI::App& app, Options& options) {
  app.set_version_flag("--version", OVWS_VERSION);
  options.common.timeout_s = kAnswerTimeoutS;
  cli::add_connection_options(app, options.common);
  app.add_option("--listen", options.listen, "address and port of the page")->capture_default_str();
  app.add_flag("--control", options.control,
               "also make a link for control; without it pages are for viewing only");
  app.add_option(
      "--links", options.links_path,
      "file (mode 0600) that keeps the links over a restart (default: make and print new "
      "links at each start)");
  app.add_option(
      "--allow-host", options.more_hosts,
      "further HOST or HOST:PORT by which browsers reach this page, e.g. a proxy's name");
  app.add_flag("--cleartext", options.cleartext,
               "allow an address that other machines can reach, although others on the network can "
               "read the links' tokens");
}

Result<void> check_options(Options& options) {
  const std::string endpoint = "tcp://" + options.listen;
  if (endpoint_fault(endpoint)) {
    return fail(Errc::invalid, "--listen",
                "must be ADDRESS:PORT with a port from 1 to 65535, e.g. 127.0.0.1:7704");
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
