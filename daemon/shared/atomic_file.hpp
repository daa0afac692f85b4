/// Atomic file replacement: readers, also after a power cut, find either the old file or the new
/// one.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <string_view>

#include "core/base/result.hpp"

namespace ovws {

/// The system calls whose order decides what a power cut leaves; tests substitute their own.
struct FileCalls {
  ssize_t (*write)(int fd, const void* bytes, std::size_t count) = ::write;
  int (*fsync)(int fd) = ::fsync;
  int (*rename)(const char* from, const char* to) = std::rename;
};

/// Replaces a file: writes and syncs a temporary file in the same folder with the old file's owner
/// and permissions, renames it over the old file, and syncs the folder. Follows a symbolic link and
/// replaces its target; refuses a device, a FIFO and a folder. Blocks on the disk. Errors
/// (Errc::unavailable, field "path") say what to do and leave the old file unchanged; if only the
/// sync of the folder fails, a power cut may leave the old or the new file.
Result<void> replace_file(const std::string& path, std::string_view content,
                          const FileCalls& calls = {});

/// Replaces a file that holds a secret: the new file has mode 0600 from its creation. It gets the
/// old file's owner, and the old file's permissions unless group or others had any. Replaces a
/// symbolic link itself, not its target.
Result<void> replace_secret_file(const std::string& path, std::string_view content,
                                 const FileCalls& calls = {});

/// The same for a new file. Errors: as replace_file, and Errc::refused if the path exists.
Result<void> create_secret_file(const std::string& path, std::string_view content);

/// Removes a file and syncs its folder; a missing file is no error. Errors: as replace_file.
Result<void> remove_file(const std::string& path, const FileCalls& calls = {});

/// Removes temporary files that killed writers left behind, and returns their number. Call it only
/// while no writer uses `folder`.
int remove_leftovers(const std::string& folder);

}  // namespace ovws
