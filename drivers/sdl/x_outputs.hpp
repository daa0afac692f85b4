/// Reads the outputs of an X server through RandR, and sets the gamma ramp of one.
#pragma once

#include <X11/Xlib.h>

#include <vector>

#include "drivers/sdl/output.hpp"

namespace ovws::sdl {

using XDisplay = ::Display;  // ovws::Display is the port

/// All outputs, in the server's order, from what it knows without probing the connectors (a probe
/// can take a second and make screens flicker). Empty if the connection broke.
std::vector<Output> read_outputs(XDisplay* display);

/// Makes grey levels pass unchanged.
void set_linear_gamma(XDisplay* display, const Output& output);

}  // namespace ovws::sdl
