/// X server probe, read-only: opens no window and changes nothing.
#pragma once

#include <optional>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/sdl/output.hpp"

namespace ovws::sdl {

struct DisplayProbe {
  std::vector<Output> outputs;
  int colour_depth_bits = 0;
  bool power_saving = false;  ///< DPMS is on: the server powers its screens down when idle
  bool asleep = false;        ///< the screens are powered down now
  int screen_saver_s = 0;     ///< idle time before blanking; 0: never
  bool composited = false;    ///< a compositing manager is running
};

/// Probes the X server. Call it in one thread at a time, and while a display is open in the thread
/// of that display; it blocks until the X server answers. Errors, field "slm.display":
/// Errc::unavailable (no display system, or it does not answer), Errc::refused (not an X server:
/// other display systems report nothing to a program without a window).
Result<DisplayProbe> probe_display();

}  // namespace ovws::sdl
