/// Private X server for a test, with two outputs (xorg_two_outputs.conf).
#pragma once

#include <sys/types.h>

#include <string>

namespace ovws::test {

class XorgServer {
 public:
  /// Starts the server with this display number and waits until it answers. Throws
  /// std::runtime_error if it does not within 10 s.
  explicit XorgServer(int number);
  ~XorgServer();  ///< SIGTERM, so that it removes its lock and socket
  XorgServer(const XorgServer&) = delete;
  XorgServer& operator=(const XorgServer&) = delete;

  const std::string& name() const { return name_; }  ///< ":7", for DISPLAY
  void kill();                                       ///< sends SIGKILL and waits for the end

 private:
  void end(int signal);

  std::string name_;
  pid_t pid_ = -1;
};

}  // namespace ovws::test
