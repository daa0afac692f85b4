/// State directory checks of `ovws doctor`: whether measurements survive a restart.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "daemon/ovws/doctor/finding.hpp"

namespace ovws::doctor {

struct StateFacts {
  std::optional<std::string> directory;  ///< none: not configured, and the service's does not exist
  bool there = false;
  bool is_folder = false;
  bool writable = false;  ///< by this user; before creation: the nearest existing parent
  bool disk_writable = true;
  std::string owner;             ///< user name of the owner; empty: this user
  std::uint64_t free_bytes = 0;  ///< free space on the directory's disk, available without root
};

/// Reads the facts about the state directory. Writes nothing, not even a test file.
StateFacts read_state(const StateConfig& config);
Findings judge(const StateFacts& facts);

}  // namespace ovws::doctor
