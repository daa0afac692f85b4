/// The folder of recordings: names of new files, and free disk space.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "proto/tables/files.hpp"

namespace ovws {

/// Whether the disk of this path has less than the 64 MiB that a recording leaves free.
bool disk_is_full(const std::string& path);

class RecordFolder {
 public:
  explicit RecordFolder(const Config& config);

  /// Path of a new recording; makes the folder. Without a name: "run-" and the time, UTC. Errors:
  /// Errc::refused (no folder is configured, the file exists already), Errc::unavailable (the
  /// folder cannot be made, or its disk is full).
  Result<std::string> new_file(const std::optional<std::string>& name) const;
  /// The recordings in the folder, the newest first, at most 100. As long as the disk does not
  /// answer, this does not return.
  RecordingList list() const;
  /// Bytes that recordings may still take; none if no folder is configured. As long as the disk
  /// does not answer, this does not return.
  std::optional<std::uint64_t> free_bytes() const;

 private:
  const std::optional<std::string> path_;
};

}  // namespace ovws
