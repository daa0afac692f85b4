/// Checks the key files of the section `security` with the rights of the daemon's user, for
/// `--check-config` and `ovws doctor`.
#pragma once

#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct KeyFileCheck {
  std::optional<Error> error;  ///< the error that the daemon's start would report
  std::string fix;             ///< shell command that fixes `error`; empty: edit the configuration
  bool read = true;            ///< false: the secret key is not checked: the caller may not read it
  std::string user;            ///< user that the daemon runs as; empty without keys
};

/// Checks the key files as the daemon's user: `ovws` for the service's configuration, else the
/// owner of the secret key, or the caller if root owns the key. Root temporarily switches its
/// effective user, so call this only while the process has one thread.
KeyFileCheck check_key_files(const std::string& config_path, const Config& config);

}  // namespace ovws
