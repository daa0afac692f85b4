/// Is there a configuration, does it read well, and does it make a sensor?
#pragma once

#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/ovws/doctor/finding.hpp"
#include "daemon/ovwsd/settings/key_check.hpp"

namespace ovws::doctor {

struct ConfigurationFacts {
  std::string path;              ///< empty: no file is named, and none is where the service's is
  std::optional<Config> config;  ///< the defaults without a file; none: it does not read well
  std::optional<Error> error;    ///< why there is no config, or why it makes no sensor
  std::optional<Error> unseen;   ///< why a daemon that starts with it would find no spots
  std::string rejected;          ///< path of saved values that were set aside; empty: none
  KeyCheck keys;
  std::string saved;             ///< as of describe_saved; empty: config.save saved nothing
  bool saved_is_unused = false;  ///< the saved values are damaged, or of another file
};

/// Empty path: the service's file, if there is one.
ConfigurationFacts read_configuration(const std::string& path);
Findings judge(const ConfigurationFacts& facts);

}  // namespace ovws::doctor
