#include "daemon/shared/key_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "daemon/shared/atomic_file.hpp"
#include "proto/reader.hpp"
#include "proto/strict_json.hpp"

namespace ovws {
namespace {

constexpr const char* kPathField = "path";
constexpr std::size_t kMaxFileBytes = 1 << 20;
constexpr int kMaxDepth = 4;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

tl::unexpected<Error> key_error(Errc code, const std::string& path, const std::string& what) {
  return fail(code, kPathField, path + ": " + what);
}

std::string credentials_folder() {
  const char* const folder = std::getenv("CREDENTIALS_DIRECTORY");
  return folder == nullptr ? std::string{} : folder;
}

Result<void> check_pair(const std::string& path, const KeyFile& keys) {
  if (public_key_of(keys.pair.secret_key) != keys.pair.public_key) {
    return key_error(Errc::invalid, path,
                     "public_key does not belong to secret_key: make both with ovws keygen");
  }
  if (keys.server_key.empty() || is_curve_key(keys.server_key)) return {};
  return key_error(
      Errc::invalid, path,
      "server_key is not a key of 40 characters: copy the daemon's public key, which its "
      "log shows at the start");
}

}  // namespace

Result<std::string> read_kept_file(const std::string& path, mode_t forbidden,
                                   const std::string& secrecy) {
  // O_NONBLOCK: opening a pipe without a writer must not block the daemon.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat about {};
  if (file.get() < 0 || ::fstat(file.get(), &about) != 0) {
    return key_error(Errc::invalid, path, std::string("cannot be read: ") + std::strerror(errno));
  }
  if (!S_ISREG(about.st_mode)) return key_error(Errc::invalid, path, "is not a file");
  if ((about.st_mode & forbidden) != 0) return key_error(Errc::invalid, path, secrecy);
  if (about.st_uid != 0 && about.st_uid != ::geteuid()) {
    return key_error(Errc::invalid, path,
                     "belongs to another user, who could change it: chown it to the user of this "
                     "program, or to root");
  }
  std::string text(kMaxFileBytes + 1, '\0');
  std::size_t size = 0;
  ssize_t got = 1;
  while (got > 0 && size < text.size()) {
    got = ::read(file.get(), text.data() + size, text.size() - size);
    if (got > 0) size += std::size_t(got);
  }
  if (got < 0) {
    return key_error(Errc::invalid, path, std::string("cannot be read: ") + std::strerror(errno));
  }
  if (size > kMaxFileBytes) return key_error(Errc::invalid, path, "is larger than 1 MiB");
  text.resize(size);
  return text;
}

std::string credential_path(const std::string& name) {
  const std::string folder = credentials_folder();
  if (folder.empty()) return {};
  const std::string path = folder + "/" + name;
  return ::access(path.c_str(), F_OK) == 0 ? path : std::string{};
}

Result<KeyFile> load_key_file(const std::string& path) {
  const std::string credentials = credentials_folder();
  const bool is_credential = !credentials.empty() && path.starts_with(credentials + "/");
  const auto text = read_kept_file(
      path, is_credential ? S_IWGRP | S_IXGRP | S_IRWXO : S_IRWXG | S_IRWXO,
      "group or others can read this secret key: chmod 600 it, or, if another user may have read "
      "it, make a new one with ovws keygen");
  if (!text) return fail(text.error());
  const auto parsed = parse_strict_json(*text, kMaxDepth, JsonComments::refused);
  if (!parsed) return key_error(Errc::invalid, path, "is not a key file made by ovws keygen");
  KeyFile keys;
  ObjectReader reader(*parsed, "");
  reader.require("public_key");
  reader.require("secret_key");
  reader.string("public_key", keys.pair.public_key);
  reader.string("secret_key", keys.pair.secret_key);
  reader.string("server_key", keys.server_key);
  if (const auto done = reader.finish(); !done) {
    return key_error(Errc::invalid, path, text_of(done.error()));
  }
  if (auto right = check_pair(path, keys); !right) return fail(right.error());
  return keys;
}

Result<void> write_key_file(const std::string& path, const KeyFile& keys, bool replace) {
  nlohmann::ordered_json content{{"public_key", keys.pair.public_key},
                                 {"secret_key", keys.pair.secret_key}};
  if (!keys.server_key.empty()) content["server_key"] = keys.server_key;
  const std::string text = content.dump(2) + "\n";
  if (replace) return replace_secret_file(path, text);
  auto created = create_secret_file(path, text);
  if (created || created.error().code != Errc::refused) return created;
  return key_error(Errc::refused, path,
                   "exists already, and users of its key would lose access: choose another name, "
                   "or use --replace");
}

}  // namespace ovws
