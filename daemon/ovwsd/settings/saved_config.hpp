/// The saved settings: an overlay in the state directory that `config.save` writes. Its values
/// replace values of the configuration file whenever that file is read.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"

namespace ovws {

/// The service's configuration file.
inline constexpr const char* kServicePath = "/etc/ovws/ovwsd.json";

/// A configuration as loaded: the file, the saved values, and the effective result.
struct LoadedConfig {
  std::string path;                    ///< file path as given; empty: no file, `file` is defaults
  Config file;                         ///< values of the file, with defaults
  Config effective;                    ///< `file` with the saved values applied
  std::optional<std::string> overlay;  ///< path of the saved values; none: no state directory
  std::vector<std::string> saved;      ///< dotted keys whose saved values are active
  std::vector<std::string> edited;     ///< keys edited in the file since they were saved: file wins
  std::string unused_reason;           ///< why the overlay is not used; empty: used, or no overlay
  std::string rejected;  ///< path of an earlier overlay that was renamed as invalid; empty: none
  bool invalid = false;  ///< the overlay is damaged, or its sensor is not usable
};

/// True if the path leads to the service's configuration file, even through links.
bool is_service_config(const std::string& path);

/// The service's state folder if `path` is the service's configuration file. It replaces
/// $STATE_DIRECTORY, which is not set for a person who checks the file.
std::optional<std::string> service_state_folder(const std::string& path);

/// Reads the configuration file (empty path: the defaults) and its overlay. The overlay is
/// `config.json` in state_directory_of the file's settings, or else in `folder`; that of `running`
/// if it is given, because a daemon keeps its state folder. Blocks on the disk; changes no file.
/// Errors: see load_config. If the overlay is bad, there is no error: `effective` is then `file`.
Result<LoadedConfig> load_with_saved(const std::string& path,
                                     const std::optional<std::string>& folder = std::nullopt,
                                     const LoadedConfig* running = nullptr);

/// Renames an invalid overlay, so that it is not read again, and adds the new name to
/// `unused_reason`. Blocks on the disk.
void set_aside_if_invalid(LoadedConfig& loaded);

std::string comma_list(const std::vector<std::string>& keys);  ///< "a, b, c"

/// One line of text: which saved values are active, which are not, and why. Empty if none exist.
std::string describe_saved(const LoadedConfig& loaded);

/// Content that `config.save` writes: settings that can change at run time and differ from the
/// file.
struct SavedValues {
  std::vector<std::string> keys;  ///< dotted, sorted; empty: no setting differs
  std::string text;               ///< text of the overlay file
  nlohmann::json owner;           ///< path of their configuration file; null: none
};
SavedValues values_to_save(const LoadedConfig& loaded, const Config& in_use);

/// Writes the overlay file atomically, or removes it if `values` has no keys. Blocks on the disk.
/// Errc::refused, field "state.directory": the overlay belongs to another configuration file. Other
/// errors: see replace_file.
Result<void> write_saved(const std::string& overlay, const SavedValues& values);

}  // namespace ovws
