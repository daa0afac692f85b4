/// A private X server with two outputs (xorg_two_outputs.conf) that a test starts and kills.
#pragma once

#include <sys/types.h>

#include <string>

namespace ovws::test {

class XorgServer {
 public:
  /// Starts one, on a free display number or on the one given, and waits until it answers. Throws
  /// std::runtime_error if it does not.
  explicit XorgServer(int number = -1);
  ~XorgServer() { kill(); }
  XorgServer(const XorgServer&) = delete;
  XorgServer& operator=(const XorgServer&) = delete;

  int number() const { return number_; }
  std::string name() const { return ":" + std::to_string(number_); }  ///< for DISPLAY
  void kill();  ///< SIGKILL, and waits until it is gone

 private:
  int number_ = -1;
  pid_t pid_ = -1;
};

}  // namespace ovws::test
