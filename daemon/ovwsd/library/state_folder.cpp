#include "daemon/ovwsd/library/state_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "daemon/shared/atomic_file.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"
#include "proto/strict_json.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kMaxDepth = 16;
constexpr std::uintmax_t kMaxFileBytes = 1U << 30;
constexpr std::string_view kSumBegin = ",\n\"sha256\": \"";
constexpr std::string_view kSumEnd = "\"\n}\n";
constexpr std::size_t kSumDigits = 64;
constexpr const char* kOutdatedSuffix = ".outdated";  // added to the name of a file set aside
constexpr std::size_t kSealSize = kSumBegin.size() + kSumDigits + kSumEnd.size();

tl::unexpected<Error> damaged(const std::string& reason) {
  return fail(Errc::invalid, "", reason);
}

Result<std::string> read_text(const fs::path& path) {
  std::error_code unknown;
  // A pipe would block for ever.
  if (!fs::is_regular_file(path, unknown) && !unknown) return damaged("it is not a file");
  const std::uintmax_t size = fs::file_size(path, unknown);
  if (!unknown && size > kMaxFileBytes) {
    return damaged("it is larger than 1 GiB, so it was not written by the daemon");
  }
  std::ifstream file(path, std::ios::binary);
  std::string text(unknown ? 0 : std::size_t(size), '\0');
  file.read(text.data(), std::streamsize(text.size()));
  if (!unknown && file) return text;
  return damaged(std::string("it cannot be read: ") + std::strerror(errno));
}

/// The checksum that a sealed text ends with.
std::string sum_of(std::string_view text) {
  return std::string(text.substr(text.size() - kSumEnd.size() - kSumDigits, kSumDigits));
}

std::string schema_of(std::string_view kind) {
  return "ovws.state." + std::string(kind) + "/1";
}

}  // namespace

std::optional<std::string> state_directory_of(const StateConfig& config) {
  if (config.directory) return config.directory;
  const char* const list = std::getenv("STATE_DIRECTORY");
  if (list == nullptr || *list == '\0') return std::nullopt;
  const std::string_view all = list;  // systemd separates folders by colons
  return std::string(all.substr(0, all.find(':')));
}

std::string seal(std::string_view schema, const json& content) {
  std::string sealed =
      "{\n\"schema\": " + json_text(schema) + ",\n\"content\": " + json_text(content, 1);
  const std::string sum = sha256_hex(sealed);
  sealed += kSumBegin;
  sealed += sum;
  sealed += kSumEnd;
  return sealed;
}

Result<StateItem> unseal(std::string_view schema, std::string_view text) {
  if (text.empty()) return damaged("it is empty");
  const bool whole = text.size() > kSealSize && text.ends_with(kSumEnd) &&
                     text.substr(text.size() - kSealSize).starts_with(kSumBegin);
  if (!whole)
    return damaged("it is cut off, or was not written by the daemon: its checksum is missing");
  const std::string_view body = text.substr(0, text.size() - kSealSize);
  const std::string_view sum = text.substr(body.size() + kSumBegin.size(), kSumDigits);
  if (sha256_hex(body) != sum) {
    return damaged("it is damaged or was changed by hand: its checksum does not match");
  }
  auto parsed = parse_strict_json(text, kMaxDepth, JsonComments::refused);
  if (!parsed) return damaged(parsed.error().reason);
  if (!parsed->is_object() || !parsed->contains("schema") || (*parsed)["schema"] != schema) {
    return damaged("its schema is not " + std::string(schema));
  }
  if (!parsed->contains("content")) return damaged("its content is missing");
  return StateItem{{}, std::move((*parsed)["content"]), std::string(sum)};
}

Result<FolderLock> lock_folder(const std::string& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return FolderLock();
  FolderLock lock(new int(fd), [](const int* held) {
    ::close(*held);
    delete held;
  });
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return lock;
  if (errno != EWOULDBLOCK) return FolderLock();
  return fail(
      Errc::unavailable, "state.directory",
      "another daemon uses " + folder + ": stop it, or give each daemon its own state.directory");
}

Result<StateFolder> StateFolder::open(const std::string& directory) {
  std::error_code failed;
  fs::create_directories(directory, failed);
  if (failed) {
    return fail(Errc::unavailable, "state.directory",
                directory + " cannot be created: " + failed.message() +
                    "; create it for the daemon's user");
  }
  const fs::directory_iterator readable(directory, failed);
  if (failed) {
    return fail(
        Errc::unavailable, "state.directory",
        directory + " cannot be read: " + failed.message() + "; give the daemon's user access");
  }
  StateFolder store(directory);
  // Leftovers are removed before the write test, because they may fill the disk.
  store.leftovers_ = remove_leftovers(directory);
  // Write test with real data: permissions do not show whether a write succeeds, and a full disk
  // still accepts an empty file.
  constexpr std::size_t kProbeBytes = 4096;
  const std::string probe = directory + "/.write-test";
  auto writable = replace_file(probe, std::string(kProbeBytes, '\n'));
  if (writable) writable = remove_file(probe);
  if (!writable) store.why_read_only_ = writable.error().reason;
  return store;
}

std::string StateFolder::path_of(std::string_view kind, std::string_view name) const {
  return directory_ + "/" + std::string(kind) + "." + std::string(name) + ".json";
}

bool StateFolder::holds(std::string_view kind, std::string_view name) const {
  std::error_code unknown;
  return fs::exists(fs::symlink_status(path_of(kind, name), unknown));
}

std::string StateFolder::text_of(std::string_view kind, const json& content) {
  return seal(schema_of(kind), content);
}

Result<std::string> StateFolder::write(std::string_view kind, std::string_view name,
                                       std::string_view text) {
  const std::string path = path_of(kind, name);
  if (text.size() > kMaxFileBytes) {
    return fail(Errc::refused, "path", path + " would be larger than 1 GiB");
  }
  if (auto written = replace_file(path, text); !written) return fail(written.error());
  ::unlink((path + kOutdatedSuffix).c_str());
  return sum_of(text);
}

Result<void> StateFolder::remove(std::string_view kind, std::string_view name) {
  const std::string path = path_of(kind, name);
  auto removed = remove_file(path);
  if (removed) ::unlink((path + kOutdatedSuffix).c_str());
  return removed;
}

Result<void> StateFolder::set_aside(std::string_view kind, std::string_view name) {
  const std::string path = path_of(kind, name);
  if (std::rename(path.c_str(), (path + kOutdatedSuffix).c_str()) == 0 || errno == ENOENT)
    return {};
  return fail(Errc::unavailable, "path", path + " cannot be renamed: " + std::strerror(errno));
}

bool StateFolder::recreate() {
  std::error_code failed;
  return fs::create_directories(directory_, failed) && !failed;
}

std::vector<std::string> StateFolder::names(std::string_view kind) const {
  std::vector<std::string> names;
  const std::string prefix = std::string(kind) + ".", suffix = ".json";
  std::error_code failed;
  for (fs::directory_iterator at(directory_, failed), end; !failed && at != end;
       at.increment(failed)) {
    const std::string file = at->path().filename();
    if (!file.starts_with(prefix) || !file.ends_with(suffix)) continue;
    if (file.size() < prefix.size() + suffix.size()) continue;
    names.push_back(file.substr(prefix.size(), file.size() - prefix.size() - suffix.size()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

Result<StateItem> StateFolder::read(std::string_view kind, std::string_view name) const {
  auto text = read_text(path_of(kind, name));
  if (!text) return fail(text.error());
  auto item = unseal(schema_of(kind), *text);
  if (item) item->name = name;
  return item;
}

}  // namespace ovws
