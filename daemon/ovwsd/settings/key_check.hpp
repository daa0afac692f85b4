/// The files of `security`, checked for the daemon by a person: `--check-config` and `ovws doctor`.
#pragma once

#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct KeyCheck {
  std::optional<Error> error;  ///< as the daemon's start would give it
  std::string fix;   ///< of `error`: a shell command; empty: the configuration has to be edited
  bool read = true;  ///< false: this user may not read the secret key, so it was not checked
  std::string user;  ///< that the daemon runs as; empty without keys
};

/// Checks as the daemon's user: `ovws` for the service's configuration, else the owner of the
/// secret key, or the caller if root owns it. Root takes that user's rights meanwhile, so call it
/// while the process has one thread.
KeyCheck check_keys(const std::string& config_path, const Config& config);

}  // namespace ovws
