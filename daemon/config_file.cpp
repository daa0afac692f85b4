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

}  // namespace

Result<void> replace_file(const std::string& path, const std::string& content) {
  const auto failure = [&path] {
    return fail(Errc::unavailable, "path", path + " cannot be written: " + std::strerror(errno));
  };
  std::string temporary = path + ".XXXXXX";
  const int fd = ::mkostemp(temporary.data(), O_CLOEXEC);
  if (fd < 0) return failure();
  const bool written = write_all(fd, content) && ::fchmod(fd, 0644) == 0 && ::fsync(fd) == 0;
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
