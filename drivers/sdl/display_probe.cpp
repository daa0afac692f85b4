#include "drivers/sdl/display_probe.hpp"

#include "drivers/sdl/video.hpp"
#include "drivers/sdl/x_server.hpp"

namespace ovws::sdl {
namespace {

/// Whether a compositing manager runs: EWMH requires that it owns the selection _NET_WM_CM_Sn.
bool is_composited(XDisplay* display) {
  const std::string name = "_NET_WM_CM_S" + std::to_string(DefaultScreen(display));
  const Atom manager = XInternAtom(display, name.c_str(), True);
  return manager != None && XGetSelectionOwner(display, manager) != None;
}

}  // namespace

Result<DisplayProbe> probe_display() {
  const auto driver = choose_driver();
  if (!driver) return fail(driver.error());
  if (*driver != "x11") {
    return fail(Errc::refused, "slm.display",
                "the output can be examined only with X11, and the display system is " + *driver +
                    ": check its mode, position and gamma by hand, or use an X11 session");
  }
  const auto connection = connect_to_x();
  if (!connection) return fail(connection.error());
  XDisplay* const display = connection->get();
  DisplayProbe probe;
  probe.outputs = read_outputs(display);
  probe.colour_depth_bits = DefaultDepth(display, DefaultScreen(display));
  const Power power = power_of(display);
  probe.power_saving = power.saving;
  probe.asleep = power.asleep;
  int interval_s = 0, blanking = 0, exposures = 0;
  XGetScreenSaver(display, &probe.screen_saver_s, &interval_s, &blanking, &exposures);
  probe.composited = is_composited(display);
  take_x_error();
  if (x_server_lost()) {
    return fail(Errc::unavailable, "slm.display",
                "the X server ended during the query: start it again");
  }
  return probe;
}

}  // namespace ovws::sdl
