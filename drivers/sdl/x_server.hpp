/// X server access: connections that do not end the process when the server ends, outputs by RandR,
/// and images.
///
/// By default Xlib calls exit() when a connection breaks, unless XSetIOErrorExitHandler was set on
/// that connection. SDL opens two connections and exposes only one. x_server.cpp therefore
/// interposes XOpenDisplay and sets the handler on every connection of the process. A gap remains:
/// a server that ends within the millisecond of XOpenDisplay's handshake still ends the process.
#pragma once

#include <X11/Xlib.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "drivers/sdl/output.hpp"

namespace ovws::sdl {

using XDisplay = ::Display;  // Xlib's type; ovws::Display is the display port

struct CloseDisplay {
  void operator()(XDisplay* display) const { XCloseDisplay(display); }
};
using Connection = std::unique_ptr<XDisplay, CloseDisplay>;

/// Connects to the X server named by DISPLAY. Sets error handlers that keep the process alive.
/// Resets the recorded errors, unless a display is open, whose lost connection must not be
/// forgotten. Errc::unavailable, field "slm.display", if no server answers.
Result<Connection> connect_to_x();

/// Whether an X connection of this process broke since the last connect_to_x.
bool x_server_lost();

/// Returns and clears the newest X error since the last call, "BadDrawable (…)"; empty: no error.
std::string take_x_error();

struct Power {
  bool saving = false;  ///< DPMS is enabled
  bool asleep = false;  ///< DPMS has powered the screens down
};
Power power_of(XDisplay* display);

/// Lists all outputs in the server's order, from the server's cached state, because probing the
/// connectors can take a second and make screens flicker. Empty if the connection broke.
std::vector<Output> read_outputs(XDisplay* display);

/// Sets a linear gamma ramp on the output, so that grey levels reach the SLM unchanged.
void set_linear_gamma(XDisplay* display, const Output& output);

/// Colours of an X image: 0xRRGGBB of each pixel, for any byte order. Errc::unavailable, field
/// "slm.display", if the image has not 8 bits each of red, green and blue in this order (for
/// example on a screen of 16 or 30 bits).
Result<Image<std::uint32_t>> colours_of(XImage& image);

}  // namespace ovws::sdl
