/// Command-line options of the programs that connect to a daemon. Inline, because CLI11 takes a
/// program 20 s to compile, in each unit that includes it.
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/shared/client.hpp"

namespace ovws::cli {

/// Adds --endpoint, --key and --server-key.
inline void add_connection_options(CLI::App& app, Common& common) {
  app.add_option("--endpoint", common.endpoint, "control endpoint of the daemon")
      ->capture_default_str()
      ->check(CLI::Validator(check_endpoint, ""));
  app.add_option("--key", common.key_path,
                 "key file of this client, made by ovws keygen, for a daemon that requires keys "
                 "(default: the service's credential ovws.key, if systemd provides one)")
      ->envname("OVWS_KEY");
  app.add_option("--server-key", common.server_key,
                 "public key of the daemon (default: server_key in the key file)")
      ->envname("OVWS_SERVER_KEY");
}

}  // namespace ovws::cli
