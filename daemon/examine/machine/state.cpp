#include "daemon/examine/machine/machine.hpp"

#include <fmt/core.h>
#include <pwd.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <filesystem>

#include "daemon/ovwsd/library/state_folder.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/shared/shell_word.hpp"

namespace ovws::examine {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> folder_of(const StateConfig& config, const std::string& path) {
  if (auto named = state_directory_of(config)) return named;
  const auto service = service_state_folder(path);
  return service && ::access(service->c_str(), F_OK) == 0 ? service : std::nullopt;
}

/// The longest existing prefix of the path: the folder in which a missing part would be created.
fs::path existing_part(const fs::path& given) {
  std::error_code failed;
  fs::path path = fs::absolute(given, failed);
  while (!fs::exists(path, failed) && path.has_parent_path() && path.parent_path() != path) {
    path = path.parent_path();
  }
  return path;
}

std::string other_owner(const struct stat& status) {
  if (status.st_uid == ::geteuid()) return {};
  const passwd* const user = ::getpwuid(status.st_uid);
  return user != nullptr ? user->pw_name : std::to_string(status.st_uid);
}

/// The daemon may see another folder under this name.
bool is_hidden(const StateFacts& facts) {
  return facts.of_daemon && (!facts.there || !facts.directory->starts_with('/'));
}

Finding judge_folder(const StateFacts& facts) {
  if (!facts.directory && facts.of_daemon) {
    return not_here("the daemon uses no state folder: daemon.store says why");
  }
  if (!facts.directory) {
    return warning(
        "no state folder is configured: references and calibrations are lost at a restart",
        "\"state\": {\"directory\": \"/var/lib/ovws\"}");
  }
  const std::string& folder = *facts.directory;
  if (is_hidden(facts))
    return not_here("the daemon uses " + folder + ", which is not visible here");
  if (facts.there && !facts.is_folder) {
    return bad(folder + " is not a folder: no measurement survives a restart",
               "\"state\": {\"directory\": \"/var/lib/ovws\"}");
  }
  if (!facts.disk_writable) {
    return bad(folder + " is on a read-only file system: new measurements cannot be stored",
               fmt::format("sudo mount -o remount,rw \"$(findmnt -no TARGET -T {})\"",
                           shell_word(folder)));
  }
  if (facts.writable) {
    return good(folder + (facts.of_daemon ? " is in use by the daemon, and writable"
                          : facts.there   ? " is writable"
                                          : " will be created when the daemon starts"));
  }
  if (facts.of_daemon && !facts.owner.empty()) return good(folder + " is in use by the daemon");
  if (!facts.there) {
    return bad(folder + " does not exist and this user cannot create it",
               fmt::format("sudo install -d -o ovws -g ovws {}", shell_word(folder)));
  }
  if (!facts.owner.empty()) {
    return not_here(
        folder + " belongs to " + facts.owner + ": only that user can check whether it is writable",
        fmt::format("sudo -u {} ovws doctor", facts.owner));
  }
  return bad(folder + " is not writable: new measurements do not survive a restart",
             "chmod u+rwx " + shell_word(folder));
}

Finding judge_space(const StateFacts& facts) {
  if (!facts.directory) return not_here("no state folder is configured");
  if (is_hidden(facts)) return not_here(*facts.directory + " is not visible here");
  constexpr std::uint64_t kMiB = 1 << 20;
  constexpr std::uint64_t kMinBytes = 16 * kMiB;           // room for some references with images
  constexpr std::uint64_t kRecommendedBytes = 256 * kMiB;  // room for gain sweeps
  const std::string says =
      fmt::format("the disk of {} has {} MiB left", *facts.directory, facts.free_bytes / kMiB);
  const std::string fix =
      fmt::format("du -xhd1 \"$(findmnt -no TARGET -T {})\"", shell_word(*facts.directory));
  if (facts.free_bytes < kMinBytes) return bad(says + ": too little to store references", fix);
  if (facts.free_bytes < kRecommendedBytes)
    return warning(says + ": too little to store gain sweeps", fix);
  return good(says);
}

/// Reads the other facts about `facts.directory`.
StateFacts looked_at(StateFacts facts) {
  if (!facts.directory) return facts;
  const fs::path part = existing_part(*facts.directory);
  struct stat status {};
  facts.there = ::stat(facts.directory->c_str(), &status) == 0;
  if (facts.there) {
    facts.is_folder = S_ISDIR(status.st_mode);
    facts.owner = other_owner(status);
  }
  std::error_code failed;
  facts.writable =
      fs::is_directory(part, failed) && ::access(part.c_str(), R_OK | W_OK | X_OK) == 0;
  struct statvfs disk {};
  if (::statvfs(part.c_str(), &disk) == 0) {
    facts.disk_writable = (disk.f_flag & ST_RDONLY) == 0;
    facts.free_bytes = std::uint64_t(disk.f_bavail) * disk.f_frsize;
  }
  return facts;
}

}  // namespace

StateFacts read_state(const StateConfig& config, const std::string& path) {
  StateFacts facts;
  facts.directory = folder_of(config, path);
  return looked_at(std::move(facts));
}

StateFacts read_state_of_daemon(const std::optional<std::string>& folder) {
  StateFacts facts;
  facts.directory = folder;
  facts.of_daemon = true;
  return looked_at(std::move(facts));
}

Findings answers(const StateFacts& facts) {
  constexpr Question<StateFacts> kQuestions[] = {
      {"state.directory", judge_folder},
      {"state.room", judge_space},
  };
  return answers<StateFacts>(kQuestions, facts);
}

}  // namespace ovws::examine
