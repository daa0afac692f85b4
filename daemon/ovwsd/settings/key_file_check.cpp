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
constexpr mode_t kOthers = S_IRWXG | S_IRWXO;

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

std::string fix_of_secret(const std::string& path, bool readable, const User& user) {
  const std::string word = shell_word(path);
  struct stat about {};
  if (is_missing(path)) {
    return "sudo ovws keygen -o " + word + " && sudo chown " + user.name + " " + word;
  }
  if (::stat(path.c_str(), &about) != 0) return path_check_command(path);
  const std::string close = "sudo chmod 600 " + word;
  const bool open = (about.st_mode & kOthers) != 0;
  if (about.st_uid != user.uid) {
    return "sudo chown " + user.name + " " + word + (open ? " && " + close : "");
  }
  if (open || (about.st_mode & S_IRUSR) == 0) return close;
  return readable ? "sudo ovws keygen -o " + word + " --replace" : path_check_command(path);
}

std::string fix_of_clients(const std::string& path, bool readable, const User& user) {
  const std::string word = shell_word(path);
  struct stat about {};
  if (is_missing(path)) return "sudoedit " + word;
  if (::stat(path.c_str(), &about) != 0) return path_check_command(path);
  const bool foreign = about.st_uid != 0 && about.st_uid != user.uid;
  const bool closed = !readable && (about.st_mode & S_IROTH) == 0;
  const std::string own = foreign ? "sudo chown root " + word : "";
  if (closed || (about.st_mode & S_IWOTH) != 0) {
    return own + (foreign ? " && " : "") + "sudo chmod 644 " + word;
  }
  if (foreign) return own;
  return readable ? "sudoedit " + word : path_check_command(path);
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
  bool readable = false;
  {
    const RightsOf rights(user);
    check.read = rights || is_missing(*secret);
    const auto safe = check.read                ? check_security(config)
                      : is_conclusive(*clients) ? check_clients(*clients)
                                                : Result<void>{};
    if (!safe) check.error = safe.error();
    readable = can_read(check.error && check.error->field == kClientsField ? *clients : *secret);
  }
  if (!check.error) return check;
  check.fix = check.error->field == kClientsField ? fix_of_clients(*clients, readable, user)
                                                  : fix_of_secret(*secret, readable, user);
  return check;
}

}  // namespace ovws
