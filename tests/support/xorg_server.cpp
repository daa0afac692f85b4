#include "tests/support/xorg_server.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>
#include <vector>

namespace ovws::test {

namespace {

[[noreturn]] void become_server(int ready_fd, const std::string& number) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that dies leaves no server behind
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const std::string ready = std::to_string(ready_fd);
  std::vector<const char*> words{"Xorg",         "-displayfd", ready.c_str(), "-config",
                                 OVWS_XORG_CONF, "-noreset",   "-nolisten",   "tcp",
                                 "-logfile",     "/dev/null",  "-novtswitch", "-sharevts"};
  if (!number.empty()) words.insert(words.begin() + 1, number.c_str());
  words.push_back(nullptr);
  execvp("Xorg", const_cast<char* const*>(words.data()));
  _exit(127);
}

// The server writes its number to `fd` once it takes connections.
std::string read_number(int fd) {
  std::string text;
  pollfd waiting{fd, POLLIN, 0};
  while (text.find('\n') == std::string::npos && poll(&waiting, 1, 10'000) > 0) {
    std::array<char, 16> part{};
    const ssize_t count = read(fd, part.data(), part.size());
    if (count <= 0) break;
    text.append(part.data(), std::size_t(count));
  }
  return text;
}

}  // namespace

XorgServer::XorgServer(int number) {
  const std::string argument = number < 0 ? "" : ":" + std::to_string(number);
  std::array<int, 2> ready{};
  if (pipe(ready.data()) != 0) throw std::runtime_error("pipe failed");
  pid_ = fork();
  if (pid_ == 0) {
    close(ready[0]);
    become_server(ready[1], argument);
  }
  close(ready[1]);
  const std::string text = read_number(ready[0]);
  close(ready[0]);
  if (text.empty()) {
    kill();
    throw std::runtime_error("Xorg did not start");
  }
  number_ = std::atoi(text.c_str());
}

void XorgServer::kill() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

}  // namespace ovws::test
