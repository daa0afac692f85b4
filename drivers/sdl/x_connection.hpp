/// RAII connection to the X server, and its power state.
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

/// Connects to the server named by DISPLAY, with the error handlers of x_guard.hpp.
/// Errc::unavailable, field "slm.display", if it does not answer.
Result<Connection> connect_to_x();

struct Power {
  bool saving = false;  ///< DPMS is enabled
  bool asleep = false;  ///< DPMS has powered the screens down
};
Power power_of(XDisplay* display);

}  // namespace ovws::sdl
