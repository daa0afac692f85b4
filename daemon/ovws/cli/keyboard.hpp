/// Keys of the terminal at standard input, one by one, without Enter.
#pragma once

#include <termios.h>

#include <optional>

namespace ovws::cli {

/// Reads single keys that are pressed from its construction on. The destructor restores the
/// terminal.
class Keyboard {
 public:
  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// The next key, '\n' for Enter; none at the end of the input or after a signal
  /// (was_interrupted).
  std::optional<char> next();

 private:
  termios before_{};
};

}  // namespace ovws::cli
