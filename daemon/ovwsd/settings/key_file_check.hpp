/// Checks the files of `security` on behalf of the daemon's user, for `--check-config` and `ovws
/// doctor`.
#pragma once

#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct KeyFileCheck {
  std::optional<Error> error;  ///< the error that the daemon's start would report
  std::string fix;             ///< shell command that fixes `error`; empty: edit the configuration
  bool read = true;  ///< false: this user may not read the secret key, so it was not checked
  std::string user;  ///< that the daemon runs as; empty without keys
};

/// Checks as the daemon's user: `ovws` for the service's configuration, else the owner of the
/// secret key, or the caller if root owns it. Root switches its effective user to that one
/// meanwhile, so call this while the process has one thread.
KeyFileCheck check_key_files(const std::string& config_path, const Config& config);

}  // namespace ovws
