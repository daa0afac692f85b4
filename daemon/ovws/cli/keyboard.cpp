#include "daemon/ovws/cli/keyboard.hpp"

#include <poll.h>
#include <unistd.h>

#include "daemon/ovws/cli/request.hpp"

namespace ovws::cli {

Keyboard::Keyboard() {
  tcgetattr(STDIN_FILENO, &before_);
  termios single = before_;
  single.c_lflag &= tcflag_t(~(ICANON | ECHO));
  tcsetattr(STDIN_FILENO, TCSAFLUSH, &single);  // discards earlier keys
}

Keyboard::~Keyboard() {
  tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

std::optional<char> Keyboard::next() {
  constexpr int kPollMs = 100;  // a signal may be handled in another thread
  while (!was_interrupted()) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, kPollMs) <= 0) continue;
    char key = 0;
    if (read(STDIN_FILENO, &key, 1) != 1) return std::nullopt;
    return key == '\r' ? '\n' : key;
  }
  return std::nullopt;
}

}  // namespace ovws::cli
