/// The command line of ovws-web.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::web {

struct Options {
  cli::Common common;
  std::string listen = "127.0.0.1:7704";  ///< address to listen on, and host in the links
  std::vector<std::string> more_hosts;    ///< further accepted host names
  std::string links_path;                 ///< empty: prints new tokens at each start
  bool control = false;
  bool cleartext = false;

  // Parsed from `listen` by check_options.
  std::string address;
  unsigned short port = 0;

  /// All accepted values of the Host header.
  std::vector<std::string> hosts() const;
};

/// Parses and checks `listen`. Errors: Errc::invalid, field "--listen", also for an address that
/// other machines can reach, unless `cleartext` is set.
Result<void> check_options(Options& options);

}  // namespace ovws::web
