#include "drivers/zmq/endpoint.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <zmq.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "proto/endpoint.hpp"

namespace ovws {
namespace {

constexpr std::string_view kIpc = "ipc://";
constexpr mode_t kSocketMode = 0660;

/// Socket file of an ipc endpoint; empty for other endpoints and for abstract names ("@name").
std::string file_of(const std::string& endpoint) {
  if (!endpoint.starts_with(kIpc) || endpoint.substr(kIpc.size()).starts_with('@')) return {};
  return endpoint.substr(kIpc.size());
}

tl::unexpected<Error> refusal(int error, const std::string& endpoint) {
  const std::string text = "endpoint " + endpoint;
  switch (error) {
    case EADDRINUSE:
      return fail(Errc::unavailable, "",
                  text + " is in use by another program; stop it, or configure another endpoint");
    case EADDRNOTAVAIL:
    case ENODEV:
      return fail(
          Errc::unavailable, "",
          text + ": this machine has no such address or interface; \"ip address\" lists them");
    case EACCES:
    case EPERM:
      return fail(Errc::unavailable, "",
                  text + ": not permitted; choose a port above 1023 or a path of your own");
    case EINVAL:
      return fail(Errc::invalid, "", text + " is malformed");
    default:
      return fail(Errc::unavailable, "", text + ": " + zmq_strerror(error));
  }
}

/// Whether another process listens at the socket file. libzmq removes the file before it binds,
/// which would take the endpoint from a running program.
bool is_in_use(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return false;
  const bool answered =
      ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ||
      errno == EAGAIN;
  ::close(fd);
  return answered;
}

/// Checks the endpoint, and prepares the socket for its kind of address.
Result<void> prepare(void* socket, const std::string& endpoint) {
  if (auto fault = endpoint_fault(endpoint)) return fail(Errc::invalid, "", *fault);
  const int ipv6 = is_ipv6(endpoint) ? 1 : 0;
  if (zmq_setsockopt(socket, ZMQ_IPV6, &ipv6, sizeof ipv6) == 0) return {};
  return refusal(zmq_errno(), endpoint);
}

}  // namespace

Result<void> bind_endpoint(void* socket, const std::string& endpoint) {
  if (auto prepared = prepare(socket, endpoint); !prepared) return prepared;
  const std::string path = file_of(endpoint);
  if (!path.empty() && is_in_use(path)) return refusal(EADDRINUSE, endpoint);
  if (zmq_bind(socket, endpoint.c_str()) != 0) return refusal(zmq_errno(), endpoint);
  if (path.empty() || ::chmod(path.c_str(), kSocketMode) == 0) return {};
  const int error = errno;
  zmq_unbind(socket, endpoint.c_str());
  return refusal(error, endpoint);
}

Result<void> connect_endpoint(void* socket, const std::string& endpoint) {
  if (auto prepared = prepare(socket, endpoint); !prepared) return prepared;
  if (zmq_connect(socket, endpoint.c_str()) != 0) return refusal(zmq_errno(), endpoint);
  return {};
}

}  // namespace ovws
