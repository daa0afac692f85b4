#include "daemon/ovwsd/settings/key_file_check.hpp"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <vector>

#include "daemon/ovwsd/access/client_guard.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/shared/shell_word.hpp"

namespace ovws {
namespace {

constexpr const char* kServiceUser = "ovws";
constexpr const char* kClientsField = "security.clients";

struct User {
  uid_t uid = 0;
  gid_t gid = 0;
  std::string name;
};

User user_of(uid_t uid) {
  const passwd* const entry = ::getpwuid(uid);
  if (entry == nullptr) return {uid, gid_t(-1), std::to_string(uid)};
  return {uid, entry->pw_gid, entry->pw_name};
}

User daemons_user(const std::string& config_path, const std::string& secret) {
  if (is_service_config(config_path)) {
    if (const passwd* const entry = ::getpwnam(kServiceUser)) return user_of(entry->pw_uid);
  }
  struct stat about {};
  const bool owned = ::stat(secret.c_str(), &about) == 0 && about.st_uid != 0;
  return user_of(owned ? about.st_uid : ::geteuid());
}

/// Scoped switch of root's effective user, group and supplementary groups to another user's.
class RightsOf {
 public:
  explicit RightsOf(const User& user) {
    if (user.uid == ::geteuid()) {
      has_ = true;
      return;
    }
    if (::geteuid() != 0) return;
    const int count = ::getgroups(0, nullptr);
    groups_.resize(count > 0 ? std::size_t(count) : 0);
    if (count < 0 || ::getgroups(count, groups_.data()) < 0) return;
    taken_ = ::initgroups(user.name.c_str(), user.gid) == 0;
    has_ = taken_ && ::setegid(user.gid) == 0 && ::seteuid(user.uid) == 0;
  }
  ~RightsOf() {
    if (!taken_) return;
    const bool back = ::seteuid(0) == 0 && ::setegid(group_) == 0 &&
                      ::setgroups(groups_.size(), groups_.data()) == 0;
    if (!back) std::abort();  // otherwise the process would run on as the wrong user
  }
  RightsOf(const RightsOf&) = delete;
  RightsOf& operator=(const RightsOf&) = delete;
  explicit operator bool() const { return has_; }

 private:
  const gid_t group_ = ::getegid();
  std::vector<gid_t> groups_;
  bool taken_ = false, has_ = false;
};

bool can_read(const std::string& path) {
  return ::faccessat(AT_FDCWD, path.c_str(), R_OK, AT_EACCESS) == 0;
}

bool is_missing(const std::string& path) {
  return ::access(path.c_str(), F_OK) != 0 && errno == ENOENT;
}

/// Shell command that shows which folder of the path denies access.
std::string path_check_command(const std::string& path) {
  return "namei -l " + shell_word(path);
}

/// Command that fixes the secret key, or else the list of clients. `readable`: by the daemon.
std::string fix_of(const std::string& path, bool secret, bool readable, const User& user) {
  const std::string word = shell_word(path);
  const std::string make = "sudo ovws keygen -o " + word, edit = "sudoedit " + word;
  const std::string own = "sudo chown " + (secret ? user.name : "root") + " " + word;
  const std::string close = std::string("sudo chmod ") + (secret ? "600 " : "644 ") + word;
  struct stat about {};
  if (is_missing(path)) return secret ? make + " && " + own : edit;
  if (::stat(path.c_str(), &about) != 0) return path_check_command(path);
  const auto has = [&about](mode_t bits) { return (about.st_mode & bits) != 0; };
  const bool foreign = about.st_uid != user.uid && (secret || about.st_uid != 0);
  const bool wrong_mode = secret ? has(S_IRWXG | S_IRWXO) || !has(S_IRUSR)
                                 : has(S_IWOTH) || (!readable && !has(S_IROTH));
  if (foreign) return wrong_mode ? own + " && " + close : own;
  if (wrong_mode) return close;
  if (!readable) return path_check_command(path);
  return secret ? make + " --replace" : edit;
}

/// True if a check of the clients file by the caller also holds for the daemon's user: root owns
/// the file, and the caller can read it.
bool is_conclusive(const std::string& clients) {
  struct stat about {};
  return ::stat(clients.c_str(), &about) == 0 && about.st_uid == 0 && can_read(clients);
}

}  // namespace

KeyFileCheck check_key_files(const std::string& config_path, const Config& config) {
  KeyFileCheck check;
  const auto& [secret, clients] = config.security;
  if (!secret || !clients) {
    if (const auto safe = check_security(config); !safe) check.error = safe.error();
    return check;
  }
  const User user = daemons_user(config_path, *secret);
  check.user = user.name;
  bool readable = false, of_secret = true;
  {
    const RightsOf rights(user);
    check.read = rights || is_missing(*secret);
    const auto safe = check.read                ? check_security(config)
                      : is_conclusive(*clients) ? check_clients(*clients)
                                                : Result<void>{};
    if (!safe) check.error = safe.error();
    of_secret = !check.error || check.error->field != kClientsField;
    readable = can_read(of_secret ? *secret : *clients);
  }
  if (!check.error) return check;
  check.fix = fix_of(of_secret ? *secret : *clients, of_secret, readable, user);
  return check;
}

}  // namespace ovws
