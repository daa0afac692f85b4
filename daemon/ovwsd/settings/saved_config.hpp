/// The saved settings: an overlay in the state directory that `config.save` writes. Its values
/// replace the configuration file's whenever the file is read.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"

namespace ovws {

/// A configuration as read: the file, the saved values, and what came of both.
struct LoadedConfig {
  std::string path;                    ///< of the file, as given; empty: none, `file` is defaults
  Config file;                         ///< what the file says, with defaults
  Config effective;                    ///< `file` with the saved values applied
  std::optional<std::string> overlay;  ///< path of the saved values; none: no state directory
  std::vector<std::string> saved;      ///< dotted keys whose saved values are active
  std::vector<std::string> edited;     ///< keys edited in the file since they were saved: file wins
  std::string unused_reason;  ///< why the overlay is not used; empty: it is, or none exists
  std::string rejected;  ///< path of an overlay that was set aside before; empty: there is none
  bool invalid = false;  ///< the overlay is damaged, or makes no usable sensor
};

/// Whether this path leads to the service's configuration file, however it is spelled.
bool is_service_config(const std::string& path);

/// The service's state folder if `path` is the service's configuration file. A person who checks
/// that file has no $STATE_DIRECTORY.
std::optional<std::string> service_state_folder(const std::string& path);

/// Reads the file (empty path: the defaults) and its overlay, `config.json` in state_directory_of
/// the file or else in `folder`. Blocks on the disk, changes nothing. Errors: see load_config. A
/// bad overlay is no error: `effective` is then `file`.
Result<LoadedConfig> load_with_saved(const std::string& path,
                                     const std::optional<std::string>& folder = std::nullopt);

/// Renames an invalid overlay, so that it is not read again, and says so in `unused_reason`. Blocks
/// on the disk.
void set_aside_if_invalid(LoadedConfig& loaded);

/// One line for a person: which saved values are active, which are not, and why. Empty: none exist.
std::string describe_saved(const LoadedConfig& loaded);

/// What `config.save` writes: the settings that can change at run time and differ from the file.
struct SavedValues {
  std::vector<std::string> keys;  ///< dotted, sorted; empty: nothing differs
  std::string text;               ///< of the overlay
  nlohmann::json owner;           ///< the configuration file that they belong to; null: none
};
SavedValues values_to_save(const LoadedConfig& loaded, const Config& in_use);

/// Writes the overlay atomically; without keys removes it. Blocks on the disk. Errors:
/// Errc::refused, field "state.directory", if the overlay belongs to another configuration file;
/// else see replace_file.
Result<void> write_saved(const std::string& overlay, const SavedValues& values);

}  // namespace ovws
