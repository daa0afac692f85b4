/// The terminal as a page that is drawn as a whole, and its keys.
#pragma once

#include <memory>

#include "core/base/result.hpp"
#include "daemon/ovws/screen/canvas.hpp"

namespace ovws::screen {

enum class Key { none, other, quit, pause, help, up, down, page_up, page_down, home, end };

/// One at a time. As long as it lives the terminal shows its page; then it is as it was before,
/// with all that stood there.
class Terminal {
 public:
  /// Colours unless NO_COLOR says otherwise; other signs than ASCII if the locale has them. Error:
  /// Errc::unavailable if $TERM names none that a page can be drawn on.
  static Result<Terminal> open();
  Terminal(Terminal&&) noexcept;
  Terminal& operator=(Terminal&&) noexcept;
  ~Terminal();

  /// As large as the terminal is now.
  Canvas blank() const;
  void show(const Canvas& canvas);
  /// Key::none at once if none was pressed.
  Key key();

 private:
  struct Impl;
  explicit Terminal(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::screen
