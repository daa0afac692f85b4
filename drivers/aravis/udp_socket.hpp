/// RAII owner of a UDP socket.
#pragma once

#include <sys/socket.h>
#include <unistd.h>

namespace ovws {

class UdpSocket {
 public:
  UdpSocket() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~UdpSocket() {
    if (fd_ >= 0) ::close(fd_);
  }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;
  int get() const { return fd_; }  ///< descriptor; negative: the socket could not be opened

 private:
  int fd_;
};

}  // namespace ovws
