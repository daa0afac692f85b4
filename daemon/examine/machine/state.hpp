/// State directory checks of `ovws doctor`: whether measurements survive a restart.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "daemon/examine/machine/finding.hpp"

namespace ovws::doctor {

struct StateFacts {
  std::optional<std::string> directory;  ///< none: not configured, and the service's does not exist
  bool of_daemon = false;                ///< `directory` is what the running daemon reports
  std::string why_none;                  ///< why a daemon uses no folder; empty: not known
  bool there = false;
  bool is_folder = false;
  bool writable = false;  ///< by this user; before creation: the nearest existing parent
  bool disk_writable = true;
  std::string owner;             ///< user name of the owner; empty: this user
  std::uint64_t free_bytes = 0;  ///< free space on the directory's disk, available without root
};

/// Reads the facts about the state directory. Writes nothing, not even a test file.
StateFacts read_state(const StateConfig& config);
/// The same about the folder that a running daemon uses; none: it uses none, because of `why_none`.
StateFacts read_state_of_daemon(const std::optional<std::string>& folder,
                                const std::string& why_none);
Findings judge(const StateFacts& facts);

}  // namespace ovws::doctor
