/// Keeps Xlib from ending this process when the X server dies or refuses a request.
///
/// Left alone, Xlib calls exit() when a connection breaks, unless XSetIOErrorExitHandler was set on
/// that very connection. SDL opens two and shows only one of them, so x_guard.cpp stands in front
/// of XOpenDisplay and sets the handler on every connection of the process. What is left: a server
/// that dies within the millisecond of XOpenDisplay's own handshake still ends the process.
#pragma once

#include <string>

namespace ovws::sdl {

/// Sets Xlib's handlers and forgets what was seen before. Call it before connections are opened.
void guard_x_connections();

/// Whether a connection broke since guard_x_connections.
bool x_server_lost();

/// The server's last refusal since the last call, "BadDrawable (…)", or empty.
std::string take_x_error();

}  // namespace ovws::sdl
