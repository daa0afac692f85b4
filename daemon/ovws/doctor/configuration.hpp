/// Configuration checks of `ovws doctor`: the file loads, describes a usable sensor, and its keys
/// are readable.
#pragma once

#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/ovws/doctor/finding.hpp"
#include "daemon/ovwsd/settings/key_file_check.hpp"

namespace ovws::doctor {

struct ConfigurationFacts {
  std::string path;              ///< empty: no file is named, and the service's does not exist
  std::optional<Config> config;  ///< the defaults without a file; none: it cannot be loaded
  std::optional<Error> error;    ///< why there is no config, or why it is unusable
  std::optional<Error> unseen;   ///< why a daemon would find no spots with it
  std::string rejected;          ///< path of saved values that were set aside; empty: none
  KeyFileCheck keys;
  std::string saved;             ///< from describe_saved; empty: nothing was saved
  bool saved_is_unused = false;  ///< the saved values are damaged, or belong to another file
};

/// Loads the file at `path`. Empty: the service's file, or the defaults if that does not exist.
ConfigurationFacts read_configuration(const std::string& path);
Findings judge(const ConfigurationFacts& facts);

}  // namespace ovws::doctor
