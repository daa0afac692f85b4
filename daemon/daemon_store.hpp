/// The daemon's store: where it is, or why there is none, and what could not be kept.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "config/config.hpp"
#include "daemon/events.hpp"
#include "daemon/guarded.hpp"
#include "daemon/store/state_store.hpp"
#include "proto/messages.hpp"

namespace ovws {

/// `config.directory`, or the first of $STATE_DIRECTORY; none: neither is set.
std::optional<std::string> state_directory_of(const StateConfig& config);

/// Thread-safe; waits for the disk. Without a store the daemon runs all the same.
class DaemonStore {
 public:
  /// In state_directory_of. A store that cannot be used or written,
  /// or none, is told here, once; what is in one that can only be read is read.
  DaemonStore(const StateConfig& config, Events& events);

  /// The item's checksum. Errors (Errc::unavailable): there is no store, or as of replace_file;
  /// `report` tells it until something can be kept again.
  Result<std::string> put(std::string_view kind, std::string_view name,
                          const nlohmann::json& content);
  /// Without a store there is nothing to drop. Errors as of remove_file.
  Result<void> drop(std::string_view kind, std::string_view name);
  /// What could not be kept of the item, or without a name of all of its kind, is lost for good and
  /// no longer told.
  void give_up(std::string_view kind, std::string_view name = {});
  std::optional<StateItem> find(std::string_view kind, std::string_view name) const;
  /// As of StateStore::load; of every file that is not whole an event says why it is not used.
  void load(std::string_view kind, const std::function<void(StateItem)>& take) const;

  StatusMessage::StorePart report() const { return report_.get(); }

 private:
  Events& events_;
  void note(const std::string& item, const std::optional<std::string>& why_not_kept);
  void tell();

  mutable std::mutex mutex_;  ///< held while the disk works
  std::optional<StateStore> store_;
  std::optional<std::string> why_none_;
  std::optional<std::string> why_read_only_;     ///< at the start, and until something is kept
  std::map<std::string, std::string> not_kept_;  ///< why, by kind and name
  Guarded<StatusMessage::StorePart> report_;     ///< never waits for the disk
};

}  // namespace ovws
