/// Exclusive lock of a state folder: one daemon process at a time uses it.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

/// The lock (flock), held while a copy lives, at most until the process ends. Null where nothing
/// can be locked: the folder cannot be made or opened, or its file system has no locks.
using FolderLock = std::shared_ptr<const int>;

/// Makes the folder if there is none, and locks it. Errc::unavailable (field "state.directory") if
/// another process holds it.
Result<FolderLock> lock_folder(const std::string& folder);

}  // namespace ovws
