/// Unique endpoints for tests: an ipc path of this process, or a currently free port.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace ovws::test {

/// Folder for this process's socket files, removed at exit with everything that libzmq leaves
/// behind.
class SocketFolder {
 public:
  SocketFolder() {
    char path[] = "/tmp/ovws-test-XXXXXX";
    path_ = ::mkdtemp(path);
  }
  ~SocketFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  SocketFolder(const SocketFolder&) = delete;
  SocketFolder& operator=(const SocketFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline std::string ipc_endpoint(const std::string& name) {
  static const SocketFolder folder;
  return "ipc://" + folder.path() + "/" + name;
}

inline std::string tcp_endpoint() {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  ::bind(fd, reinterpret_cast<const sockaddr*>(&address), size);
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(fd);
  return "tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

/// A free port of the IPv6 loopback address; empty on a machine without IPv6.
inline std::string ipv6_endpoint() {
  sockaddr_in6 address{};
  address.sin6_family = AF_INET6;
  address.sin6_addr = in6addr_loopback;
  socklen_t size = sizeof address;
  const int fd = ::socket(AF_INET6, SOCK_STREAM, 0);
  const bool bound = fd >= 0 && ::bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0;
  if (bound) ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  if (fd >= 0) ::close(fd);
  return bound ? "tcp://[::1]:" + std::to_string(ntohs(address.sin6_port)) : "";
}

}  // namespace ovws::test
