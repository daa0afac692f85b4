#include "daemon/config_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace ovws {
namespace {

bool write_all(int fd, const std::string& content) {
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t written = ::write(fd, content.data() + done, content.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    done += std::size_t(written);
  }
  return true;
}

bool sync_folder(const std::filesystem::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool synced = ::fsync(fd) == 0;
  ::close(fd);
  return synced;
}

/// The file keeps its owner, as far as we may give it, and its permissions.
bool like_before(int fd, const std::string& path) {
  struct stat before {};
  if (::stat(path.c_str(), &before) != 0) return ::fchmod(fd, 0644) == 0;
  if (::fchown(fd, before.st_uid, before.st_gid) != 0 && errno != EPERM) return false;
  return ::fchmod(fd, before.st_mode & 07777) == 0;
}

/// What a link leads to is replaced, not the link.
std::string target_of(const std::string& path) {
  std::error_code unknown;
  const auto target = std::filesystem::canonical(path, unknown);
  return unknown ? path : target.string();
}

}  // namespace

Result<void> replace_file(const std::string& link, const std::string& content) {
  const std::string path = target_of(link);
  const auto failure = [&path] {
    return fail(Errc::unavailable, "path", path + " cannot be written: " + std::strerror(errno));
  };
  std::string temporary = path + ".XXXXXX";
  const int fd = ::mkostemp(temporary.data(), O_CLOEXEC);
  if (fd < 0) return failure();
  const bool written = write_all(fd, content) && like_before(fd, path) && ::fsync(fd) == 0;
  const bool moved = ::close(fd) == 0 && written && ::rename(temporary.c_str(), path.c_str()) == 0;
  if (!moved) {
    auto error = failure();
    ::unlink(temporary.c_str());
    return error;
  }
  const auto folder = std::filesystem::absolute(path).parent_path();
  if (!sync_folder(folder)) return failure();
  return {};
}

}  // namespace ovws
