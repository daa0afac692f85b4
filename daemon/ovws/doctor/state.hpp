/// Can a daemon keep what it measures over a restart?
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "daemon/ovws/doctor/finding.hpp"

namespace ovws::doctor {

struct StateFacts {
  std::optional<std::string> directory;  ///< none: none is named, and the service has none
  bool there = false;
  bool is_folder = false;
  bool writable = false;  ///< by this user; of one that is not there, the folder it would be in
  bool disk_writable = true;
  std::string owner;             ///< its name, if that is another user; else empty
  std::uint64_t free_bytes = 0;  ///< on its disk, for who is not root
};

/// Writes nothing, not even to try.
StateFacts read_state(const StateConfig& config);
Findings judge(const StateFacts& facts);

}  // namespace ovws::doctor
