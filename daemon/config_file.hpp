/// Writes a file so that a reader, or a power cut, finds either the old one or the new one, whole.
#pragma once

#include <string>

#include "core/base/result.hpp"

namespace ovws {

/// Errors (Errc::unavailable, field "path") leave the old file as it was. Waits for the disk.
Result<void> replace_file(const std::string& path, const std::string& content);

}  // namespace ovws
