/// Xlib error handlers that keep the process alive when the X server dies or refuses a request.
///
/// By default Xlib calls exit() when a connection breaks, unless XSetIOErrorExitHandler was set on
/// that connection. SDL opens two connections and exposes only one, so x_guard.cpp interposes
/// XOpenDisplay and sets the handler on every connection of the process. One gap remains: a server
/// that dies within the millisecond of XOpenDisplay's handshake still ends the process.
#pragma once

#include <string>

namespace ovws::sdl {

/// Installs the handlers and resets the recorded errors. Call it before connections are opened.
void guard_x_connections();

/// Whether a connection broke since guard_x_connections.
bool x_server_lost();

/// Returns and clears the last X error since the last call, "BadDrawable (…)", or empty.
std::string take_x_error();

}  // namespace ovws::sdl
