/// SDL display driver: shows the SLM's image pixel-exact on a named output, or fails.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/port/display.hpp"

namespace ovws {

struct SdlConfig {
  std::string output;  ///< X output name ("HDMI-1") or EDID monitor name; never an index
  int width = 1280;
  int height = 768;
  bool allow_primary = false;  ///< accept the primary output, or the only one
};

/// Opens the configured output. Main thread only. Errors (field "slm.display", "slm.width", …):
/// Errc::unavailable if there is no display system or no such output (the reason lists the
/// outputs); Errc::refused if the output's mode differs, the output is the primary one, or a
/// display is open already. After the X server ended, destroy the display and open it again.
///
/// On X, `present` returns when the server has copied the image; the output sends the image with
/// its next refresh. Opening sets a linear gamma ramp and wakes the screens. Each `check` handles
/// events; once a second, or after a change, it also verifies output, mode, gamma and window.
Result<std::unique_ptr<Display>> open_sdl_display(const SdlConfig& config);

/// Lists the X server's outputs, also while a display is open. Main thread only; blocks until the X
/// server answers, usually for milliseconds. Errors: see probe_display.
Result<std::vector<DisplayOutput>> list_sdl_outputs(const SdlConfig& config);

/// Checks whether the configured output could be opened, without opening it. Errors: as of
/// open_sdl_display. Other display systems than X tell nothing before they are opened: no error.
Result<void> check_sdl_output(const SdlConfig& config);

}  // namespace ovws
