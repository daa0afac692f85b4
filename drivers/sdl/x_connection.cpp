#include "drivers/sdl/x_connection.hpp"

#include <X11/extensions/dpms.h>

#include "drivers/sdl/video.hpp"
#include "drivers/sdl/x_guard.hpp"

namespace ovws::sdl {

Result<Connection> connect_to_x() {
  guard_x_connections();
  Connection display(XOpenDisplay(nullptr));
  if (display != nullptr) return display;
  return fail(Errc::unavailable, "slm.display",
              "the X server DISPLAY=" + environment("DISPLAY") +
                  " does not answer: start it, and give this user access to it (XAUTHORITY)");
}

Power power_of(XDisplay* display) {
  int event_base = 0, error_base = 0;
  CARD16 level = DPMSModeOn;
  BOOL enabled = False;
  if (!DPMSQueryExtension(display, &event_base, &error_base) || !DPMSCapable(display) ||
      !DPMSInfo(display, &level, &enabled) || !enabled) {
    return {};
  }
  return {true, level != DPMSModeOn};
}

}  // namespace ovws::sdl
