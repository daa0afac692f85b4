/// Display driver on SDL: shows the SLM's image pixel-exact on a named output, or fails.
#pragma once

#include <memory>
#include <string>

#include "core/port/display.hpp"

namespace ovws {

struct SdlConfig {
  std::string output;  ///< X output name ("HDMI-1") or EDID monitor name; never an index
  int width = 1280;
  int height = 768;
  bool allow_primary = false;  ///< allow the primary or only output
};

/// Opens the output. Main thread only. Errors (field "slm.display", "slm.width", …):
/// Errc::unavailable if there is no display system or no such output (the reason lists the
/// outputs), Errc::refused if its mode differs, it is the primary output, or a display is open
/// already. After the X server died, destroy the display and open it again.
///
/// On X, `present` returns when the server has copied the image; the output sends it with its next
/// refresh. Opening sets a linear gamma ramp and wakes the screens. `check` handles events on each
/// call, and verifies output, mode, gamma and window once a second.
Result<std::unique_ptr<Display>> open_sdl_display(const SdlConfig& config);

}  // namespace ovws
