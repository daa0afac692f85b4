#include "daemon/ovwsd/record/record_folder.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <system_error>

#include "daemon/ovwsd/library/state_folder.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMinFreeBytes = 64 << 20;  // free disk space that a recording leaves

std::optional<std::string> path_in(const Config& config) {
  if (config.record.directory) return config.record.directory;
  const auto state = state_directory_of(config.state);
  return state ? std::optional(*state + "/recordings") : std::nullopt;
}

std::optional<std::uint64_t> free_bytes_at(const std::string& path) {
  struct statvfs disk {};
  if (::statvfs(path.c_str(), &disk) != 0) return std::nullopt;
  const std::uint64_t bytes = disk.f_bavail * disk.f_frsize;
  return bytes < kMinFreeBytes ? 0 : bytes - kMinFreeBytes;
}

/// A name by the time that no file in `folder` has yet.
std::string name_by_time(const std::string& folder) {
  const std::string name = fmt::format("run-{:%Y%m%d-%H%M%S}", fmt::gmtime(std::time(nullptr)));
  std::string free = name;
  std::error_code failed;
  for (int k = 2; fs::exists(folder + "/" + free + ".h5", failed); ++k) {
    free = fmt::format("{}-{}", name, k);
  }
  return free;
}

}  // namespace

bool disk_is_full(const std::string& path) {
  return free_bytes_at(path) == std::uint64_t{0};
}

RecordFolder::RecordFolder(const Config& config) : path_(path_in(config)) {}

Result<std::string> RecordFolder::new_file(const std::optional<std::string>& name) const {
  if (!path_) {
    return fail(Errc::refused, "record.directory",
                "no folder for recordings is configured: set record.directory or state.directory");
  }
  std::error_code failed;
  fs::create_directories(*path_, failed);
  if (failed) {
    return fail(Errc::unavailable, "record.directory",
                *path_ + " cannot be created: " + failed.message());
  }
  const std::string file = name ? *name : name_by_time(*path_);
  const std::string path = fs::absolute(*path_ + "/" + file + ".h5", failed).string();
  if (fs::exists(path, failed)) {
    return fail(Errc::refused, "name", path + " already exists: choose another name");
  }
  if (disk_is_full(*path_)) {
    return fail(Errc::unavailable, "record.directory",
                *path_ + " has less than 64 MiB of free space: delete some files");
  }
  return path;
}

RecordingList RecordFolder::list() const {
  constexpr std::size_t kMaxListed = 100;
  RecordingList list;
  if (!path_) return list;
  std::error_code failed;
  list.folder = fs::absolute(*path_, failed).string();
  for (fs::directory_iterator at(*list.folder, failed), end; !failed && at != end;
       at.increment(failed)) {
    const fs::path& path = at->path();
    struct stat about {};
    if (path.extension() != ".h5" || ::lstat(path.c_str(), &about) != 0) continue;
    if (!S_ISREG(about.st_mode)) continue;
    const timespec& changed = about.st_mtim;
    list.recordings.push_back({path.stem().string(), path.string(), std::uint64_t(about.st_size),
                               std::int64_t(changed.tv_sec) * 1'000'000'000 + changed.tv_nsec});
  }
  auto& all = list.recordings;
  std::sort(all.begin(), all.end(), [](const RecordingFile& a, const RecordingFile& b) {
    return a.t_modified_ns > b.t_modified_ns;
  });
  if (all.size() > kMaxListed) {
    list.left_off = int(all.size() - kMaxListed);
    all.resize(kMaxListed);
  }
  return list;
}

std::optional<std::uint64_t> RecordFolder::free_bytes() const {
  if (!path_) return std::nullopt;
  std::error_code failed;
  fs::path folder = fs::absolute(*path_, failed);  // the first recording makes it
  while (!fs::exists(folder, failed) && folder.has_relative_path()) folder = folder.parent_path();
  return free_bytes_at(folder);
}

}  // namespace ovws
