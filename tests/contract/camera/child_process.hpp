/// A helper program that a test starts, talks to in lines, freezes and kills.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace ovws::testing {

/// Ends (SIGKILL) with its owner. Own bugs (the program does not start) throw.
class ChildProcess {
 public:
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  void write_line(const std::string& line);
  std::string read_line();  ///< waits; throws at the end of the output
  void send_signal(int number);
  void kill();

 private:
  pid_t pid_ = -1;
  int to_child_ = -1;
  int from_child_ = -1;
};

}  // namespace ovws::testing
