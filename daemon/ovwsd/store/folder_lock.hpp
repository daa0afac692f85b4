/// One process at a time owns a folder of kept files.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

/// Held (flock) as long as a copy lives, at most until the process ends. Null where there is
/// nothing to hold: the folder cannot be made or opened, or its file system has no locks.
using FolderLock = std::shared_ptr<const int>;

/// Makes the folder if there is none. Errc::unavailable (field "state.directory") if another
/// process holds it.
Result<FolderLock> lock_folder(const std::string& folder);

}  // namespace ovws
