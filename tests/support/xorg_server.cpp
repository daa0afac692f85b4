#include "tests/support/xorg_server.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>

namespace ovws::test {

namespace {

[[noreturn]] void become_server(const std::string& name) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // end with the test, even if it crashes
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  execlp("Xorg", "Xorg", name.c_str(), "-config", OVWS_XORG_CONF, "-logfile", "/dev/null",
         "-noreset", "-nolisten", "tcp", "-novtswitch", "-sharevts", nullptr);
  _exit(127);
}

bool answers(int number) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::snprintf(address.sun_path, sizeof address.sun_path, "/tmp/.X11-unix/X%d", number);
  const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
  const bool connected =
      connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(fd);
  return connected;
}

}  // namespace

XorgServer::XorgServer(int number) : name_(":" + std::to_string(number)) {
  pid_ = fork();
  if (pid_ == 0) become_server(name_);
  for (int tries = 0; tries < 1000; ++tries) {
    if (answers(number)) return;
    if (waitpid(pid_, nullptr, WNOHANG) == pid_) {
      pid_ = -1;
      break;
    }
    usleep(10'000);
  }
  kill();
  throw std::runtime_error("Xorg " + name_ + " did not start");
}

XorgServer::~XorgServer() {
  end(SIGTERM);
}

void XorgServer::kill() {
  end(SIGKILL);
}

void XorgServer::end(int signal) {
  if (pid_ <= 0) return;
  ::kill(pid_, signal);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

}  // namespace ovws::test
