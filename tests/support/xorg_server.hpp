/// A private X server with two outputs (xorg_two_outputs.conf) that a test starts and kills.
#pragma once

#include <sys/types.h>

#include <string>

namespace ovws::test {

class XorgServer {
 public:
  /// Starts one of that display number and waits until it answers. Throws std::runtime_error if it
  /// does not.
  explicit XorgServer(int number);
  ~XorgServer();  ///< ends it in peace, so that it removes its lock and socket
  XorgServer(const XorgServer&) = delete;
  XorgServer& operator=(const XorgServer&) = delete;

  const std::string& name() const { return name_; }  ///< ":7", for DISPLAY
  void kill();                                       ///< SIGKILL, and waits until it is gone

 private:
  void end(int signal);

  std::string name_;
  pid_t pid_ = -1;
};

}  // namespace ovws::test
