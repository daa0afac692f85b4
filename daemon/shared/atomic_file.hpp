/// Writes a file so that a reader, or a power cut, finds either the old one or the new one, whole.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <string_view>

#include "core/base/result.hpp"

namespace ovws {

/// The system calls whose order decides what a power cut leaves; a test puts its own in their
/// place.
struct FileCalls {
  ssize_t (*write)(int fd, const void* bytes, std::size_t count) = ::write;
  int (*fsync)(int fd) = ::fsync;
  int (*rename)(const char* from, const char* to) = std::rename;
};

/// A temporary file beside the old one is written and synchronised, takes the old one's name, owner
/// and permissions, and then the folder is synchronised. What a link leads to is replaced, not the
/// link. Waits for the disk. Errors (Errc::unavailable, field "path") say what to do and leave the
/// old file as it was; only if the folder cannot be synchronised, either may be found after a power
/// cut.
Result<void> replace_file(const std::string& path, std::string_view content,
                          const FileCalls& calls = {});

/// The same for a secret: the new file is of mode 0600 from the beginning. It takes the old one's
/// owner, and its permissions unless group or others had any; a link itself is replaced.
Result<void> replace_secret_file(const std::string& path, std::string_view content,
                                 const FileCalls& calls = {});

/// Removes a file for good; it is no error if there is none. Otherwise as replace_file.
Result<void> remove_file(const std::string& path, const FileCalls& calls = {});

/// Removes the temporary files of writers that were killed, and returns how many. To be called when
/// no writer uses `folder`.
int remove_leftovers(const std::string& folder);

}  // namespace ovws
