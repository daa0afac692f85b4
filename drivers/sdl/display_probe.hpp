/// A look at the X server that opens no window and changes nothing.
#pragma once

#include <optional>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/sdl/output.hpp"

namespace ovws::sdl {

struct DisplayProbe {
  std::vector<Output> outputs;
  int colour_depth_bits = 0;
  bool power_saving = false;  ///< the server switches its screens off when nobody touches it (DPMS)
  bool asleep = false;        ///< it has done so
  int screen_saver_s = 0;     ///< after so long without a touch; 0: never
  bool composited = false;    ///< a program draws the desktop together from its windows' pictures
};

/// One thread at a time, and no display may be open; waits as long as the X server. Errors, field
/// "slm.display": Errc::unavailable, there is no display system or it does not answer;
/// Errc::refused, it is none of X's, which tells nothing to who shows nothing.
Result<DisplayProbe> probe_display();

}  // namespace ovws::sdl
