/// The command line of ovws-web.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::web {

struct Options {
  cli::Common common;
  std::string listen = "127.0.0.1:7704";
  std::vector<std::string> more_hosts;  ///< names under which a browser may reach this server
  std::string links_path;               ///< empty: new tokens at each start, printed
  bool control = false;
  bool cleartext = false;

  // Of `listen`, by check_options.
  std::string address;
  unsigned short port = 0;

  /// "127.0.0.1:7704": what the links name.
  std::string host() const;
  /// All that a browser may call this server.
  std::vector<std::string> hosts() const;
};

void add_options(CLI::App& app, Options& options);

/// Takes `listen` apart. Errors: Errc::invalid, field "--listen", also for an address that other
/// machines reach, unless that was asked for.
Result<void> check_options(Options& options);

}  // namespace ovws::web
