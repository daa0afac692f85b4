/// A connection to the X server that closes itself, and what any holder of one may ask.
#pragma once

#include <X11/Xlib.h>

#include <memory>

#include "core/base/result.hpp"
#include "drivers/sdl/x_outputs.hpp"

namespace ovws::sdl {

struct CloseDisplay {
  void operator()(XDisplay* display) const { XCloseDisplay(display); }
};
using Connection = std::unique_ptr<XDisplay, CloseDisplay>;

/// To the server that DISPLAY names, guarded (x_guard.hpp). Errc::unavailable, field "slm.display",
/// if it does not answer.
Result<Connection> connect_to_x();

struct Power {
  bool saving = false;  ///< DPMS is switched on
  bool asleep = false;  ///< and has switched the screens off
};
Power power_of(XDisplay* display);

}  // namespace ovws::sdl
