#include "daemon/shared/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace ovws {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUnique = ".XXXXXX";  // template of mkostemps
constexpr std::string_view kTemporary = ".ovws-tmp";

const char* remedy(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return ": free some space there";
    case EROFS:
      return ": the file system is read-only, mount it for writing or choose another folder";
    case EACCES:
    case EPERM:
      return ": give the user of this program write permission in this folder";
    case ENOENT:
      return ": create the folder, or choose another one";
    case ENOTDIR:
      return ": choose another folder";
    case EEXIST:
    case ENAMETOOLONG:
      return ": choose another name";
    default:
      return ": check the disk, or choose another folder";
  }
}

tl::unexpected<Error> failure(const std::string& path, const char* what) {
  const int error = errno;
  return fail(error == EEXIST ? Errc::refused : Errc::unavailable, "path",
              path + " cannot be " + what + ": " + std::strerror(error) + remedy(error));
}

bool write_all(int fd, std::string_view content, const FileCalls& calls) {
  while (!content.empty()) {
    const ssize_t written = calls.write(fd, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    content.remove_prefix(std::size_t(written));
  }
  return true;
}

Result<void> sync_folder_of(const std::string& path, const FileCalls& calls) {
  const auto folder = fs::absolute(path).parent_path();
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return failure(folder, "synchronised");
  const bool synced = calls.fsync(fd) == 0;
  auto unsynced = failure(folder, "synchronised");
  ::close(fd);
  if (!synced) return unsynced;
  return {};
}

/// Copies owner (if permitted) and permissions of the old file; a new file gets mode 0644.
bool copy_permissions(int fd, const std::string& path) {
  struct stat before {};
  if (::stat(path.c_str(), &before) != 0) return ::fchmod(fd, 0644) == 0;
  if (::fchown(fd, before.st_uid, before.st_gid) != 0 && errno != EPERM) return false;
  return ::fchmod(fd, before.st_mode & 07777) == 0;
}

/// Copies the old file's owner, and its permissions unless group or others have any. Ignores a
/// symbolic link: another user could have chosen its target.
bool copy_secret_permissions(int fd, const std::string& path) {
  struct stat before {};
  if (::lstat(path.c_str(), &before) != 0 || !S_ISREG(before.st_mode)) return true;
  if (::fchown(fd, before.st_uid, before.st_gid) != 0 && errno != EPERM) return false;
  const mode_t mode = before.st_mode & 07777;
  return (mode & ~mode_t(S_IRWXU)) != 0 || ::fchmod(fd, mode) == 0;
}

std::string target_of(const std::string& path) {
  std::error_code unknown;
  const auto target = fs::canonical(path, unknown);
  return unknown ? path : target.string();
}

/// Whether the name is that of a temporary file: NAME.123456.ovws-tmp.
bool is_leftover(std::string_view file) {
  if (!file.ends_with(kTemporary)) return false;
  file.remove_suffix(kTemporary.size());
  return file.size() > kUnique.size() && file[file.size() - kUnique.size()] == '.';
}

using PermissionPolicy = bool (*)(int fd, const std::string& path);

/// Replaces the file atomically; `apply_permissions` sets owner and permissions of the new file.
Result<void> replace(const std::string& path, std::string_view content,
                     PermissionPolicy apply_permissions, const FileCalls& calls) {
  struct stat before {};  // also of what a symbolic link leads to: /dev/stdout is one
  if (::stat(path.c_str(), &before) == 0 && !S_ISREG(before.st_mode)) {
    return fail(Errc::unavailable, "path", path + " is not a regular file: choose another name");
  }
  std::string temporary = path + std::string(kUnique) + std::string(kTemporary);
  const int fd = ::mkostemps(temporary.data(), int(kTemporary.size()), O_CLOEXEC);
  if (fd < 0) return failure(path, "written");
  const bool written =
      write_all(fd, content, calls) && apply_permissions(fd, path) && calls.fsync(fd) == 0;
  auto unwritten = failure(path, "written");
  if (::close(fd) != 0 || !written || calls.rename(temporary.c_str(), path.c_str()) != 0) {
    if (written) unwritten = failure(path, "written");
    ::unlink(temporary.c_str());
    return unwritten;
  }
  return sync_folder_of(path, calls);
}

}  // namespace

Result<void> replace_file(const std::string& path, std::string_view content,
                          const FileCalls& calls) {
  return replace(target_of(path), content, copy_permissions, calls);
}

Result<void> replace_secret_file(const std::string& path, std::string_view content,
                                 const FileCalls& calls) {
  return replace(path, content, copy_secret_permissions, calls);  // mkostemps sets mode 0600
}

Result<void> create_secret_file(const std::string& path, std::string_view content) {
  const auto rename_to_new = [](const char* from, const char* to) {
    if (::renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0) return 0;
    if (errno != EINVAL && errno != ENOSYS) return -1;  // else not with this file system, as NFS
    return ::link(from, to) == 0 ? ::unlink(from) : -1;
  };
  return replace_secret_file(path, content, {::write, ::fsync, rename_to_new});
}

Result<void> remove_file(const std::string& path, const FileCalls& calls) {
  if (::unlink(path.c_str()) == 0) return sync_folder_of(path, calls);
  const int why = errno;
  if (why == ENOENT) return {};
  auto unremoved = failure(path, "removed");
  // A read-only file system reports EROFS even if the file does not exist.
  struct stat found {};
  if (why == EROFS && ::lstat(path.c_str(), &found) != 0 && errno == ENOENT) return {};
  return unremoved;
}

int remove_leftovers(const std::string& folder) {
  int removed = 0;
  std::error_code failed;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    const bool left = is_leftover(at->path().filename().string());
    if (left && ::unlink(at->path().c_str()) == 0) ++removed;
  }
  return removed;
}

}  // namespace ovws
