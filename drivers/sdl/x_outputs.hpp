/// Outputs of an X server by RandR: list them, and set a linear gamma ramp.
#pragma once

#include <X11/Xlib.h>

#include <vector>

#include "drivers/sdl/output.hpp"

namespace ovws::sdl {

using XDisplay = ::Display;  // ovws::Display is the port

/// All outputs in the server's order, from its cached state: probing the connectors can take a
/// second and make screens flicker. Empty if the connection broke.
std::vector<Output> read_outputs(XDisplay* display);

/// Sets a linear gamma ramp, so that grey levels pass unchanged.
void set_linear_gamma(XDisplay* display, const Output& output);

}  // namespace ovws::sdl
