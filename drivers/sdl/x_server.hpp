/// The X server: connections that survive its death, its outputs by RandR, and its images.
///
/// By default Xlib calls exit() when a connection breaks, unless XSetIOErrorExitHandler was set on
/// that connection. SDL opens two connections and exposes only one, so x_server.cpp interposes
/// XOpenDisplay and sets the handler on every connection of the process. One gap remains: a server
/// that dies within the millisecond of XOpenDisplay's handshake still ends the process.
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

using XDisplay = ::Display;  // ovws::Display is the port

struct CloseDisplay {
  void operator()(XDisplay* display) const { XCloseDisplay(display); }
};
using Connection = std::unique_ptr<XDisplay, CloseDisplay>;

/// Connects to the server named by DISPLAY, with error handlers that keep the process alive, and
/// resets the recorded errors. Errc::unavailable, field "slm.display", if it does not answer.
Result<Connection> connect_to_x();

/// Whether a connection broke since connect_to_x.
bool x_server_lost();

/// Returns and clears the last X error since the last call, "BadDrawable (…)", or empty.
std::string take_x_error();

struct Power {
  bool saving = false;  ///< DPMS is enabled
  bool asleep = false;  ///< DPMS has powered the screens down
};
Power power_of(XDisplay* display);

/// All outputs in the server's order, from its cached state: probing the connectors can take a
/// second and make screens flicker. Empty if the connection broke.
std::vector<Output> read_outputs(XDisplay* display);

/// Sets a linear gamma ramp, so that grey levels pass unchanged.
void set_linear_gamma(XDisplay* display, const Output& output);

/// 0xRRGGBB of each pixel, for any byte order. Errc::unavailable, field "slm.display", if the image
/// does not have 8 bits each of red, green and blue in this order (a screen of 16 or 30 bits).
Result<Image<std::uint32_t>> colours_of(XImage& image);

}  // namespace ovws::sdl
