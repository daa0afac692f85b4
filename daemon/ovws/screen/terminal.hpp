/// Terminal output of whole canvases, and keyboard input (ncurses).
#pragma once

#include <memory>

#include "core/base/result.hpp"
#include "daemon/ovws/screen/canvas.hpp"

namespace ovws::screen {

/// Full-screen mode of the terminal; one instance at a time. The destructor restores the previous
/// contents of the terminal.
class Terminal {
 public:
  /// Enters full-screen mode. Uses colours unless NO_COLOR is set, and Unicode in a UTF-8 locale.
  /// Error: Errc::unavailable if the terminal named by $TERM does not support full-screen mode.
  static Result<Terminal> open();
  Terminal(Terminal&&) noexcept;
  Terminal& operator=(Terminal&&) noexcept;
  ~Terminal();

  /// An empty canvas of the terminal's current size.
  Canvas blank() const;
  void show(const Canvas& canvas);
  /// Next key that was pressed; 0 at once if no key was pressed. Keys without a character are those
  /// of a pager: k, j, b and f for up, down, page up and page down, g and G for home and end.
  int key();

 private:
  struct Impl;
  explicit Terminal(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::screen
