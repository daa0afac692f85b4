/// Child process of a test: exchanges lines, can be frozen and killed.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace ovws::testing {

/// Killed (SIGKILL) by the destructor. Throws if the program does not start.
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
