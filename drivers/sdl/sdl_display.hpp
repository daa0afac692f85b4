/// The SLM as a second display, through SDL: pixel-exact, on a named output, or not at all.
#pragma once

#include <memory>
#include <string>

#include "core/port/display.hpp"

namespace ovws {

struct SdlConfig {
  std::string output;  ///< X output name ("HDMI-1") or the monitor's EDID name; never an index
  int width = 1280;
  int height = 768;
  bool allow_primary = false;  ///< else refused if the output is the primary or the only one
};

/// Main thread only. Errors (field "slm.display", "slm.width", …): Errc::unavailable if there is no
/// display system or no such output (the reason lists those there are), Errc::refused if its mode
/// differs or it is the primary one, or if a display is open already. After the X server died,
/// destroy the display and call again: it opens anew.
///
/// On X, `present` returns when the server has copied the picture; the output sends it within its
/// next refresh. Opening makes the output's gamma ramp linear and wakes the screens. `check` looks
/// at events each time, at output, mode, gamma and window once a second.
Result<std::unique_ptr<Display>> open_sdl_display(const SdlConfig& config);

}  // namespace ovws
