/// Configuration checks of `ovws doctor`: the file loads, describes a usable sensor, and its keys
/// are readable.
#pragma once

#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/examine/machine/finding.hpp"
#include "daemon/ovwsd/settings/key_file_check.hpp"

namespace ovws::doctor {

struct ConfigurationFacts {
  std::string path;              ///< file to load; empty: none is named, and the service has none
  std::optional<Config> config;  ///< the defaults if there is no file; none: loading failed
  std::optional<Error> error;    ///< why `config` is missing or unusable
  std::optional<Error> unseen;   ///< why a daemon would find no spots with this configuration
  std::optional<Error> zeroth_order;  ///< why it disturbs; none: it is outside the region
  std::string daemon;                 ///< endpoint of the daemon whose settings `config`, `unseen`
                                      ///< and `zeroth_order` are about; empty: those of the file
  std::string rejected;               ///< path of saved values that were set aside; empty: none
  KeyFileCheck keys;
  std::string saved;             ///< saved settings as text (describe_saved); empty: none
  bool saved_is_unused = false;  ///< the saved values are damaged, or of another configuration file
};

/// Loads the configuration file at `path`. With an empty `path`: the service's file, or the
/// defaults if the service has no file.
ConfigurationFacts read_configuration(const std::string& path);
/// Replaces what is judged by the settings that a running daemon uses. `layout_fault`: why it finds
/// no spots, as its status says; empty: it does. What was found about the file stays.
void judge_instead(ConfigurationFacts& facts, const Config& in_use, const std::string& endpoint,
                   const std::string& layout_fault);
Findings judge(const ConfigurationFacts& facts);

}  // namespace ovws::doctor
