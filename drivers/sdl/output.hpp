/// Description of a display output, and checks whether it may drive the SLM.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws::sdl {

struct Output {
  std::string name;     ///< "HDMI-1"
  std::string monitor;  ///< monitor name in the EDID; empty: none
  bool connected = false;
  bool primary = false;
  int x = 0, y = 0;           ///< top left corner on the desktop, pixels
  int width = 0, height = 0;  ///< area of the desktop, pixels; 0 x 0: switched off
  int mode_width = 0;         ///< signal to the device; differs if the desktop is scaled
  int mode_height = 0;
  bool upright = true;       ///< neither rotated nor mirrored
  bool linear_gamma = true;  ///< linear gamma ramp: grey levels are unchanged
  double refresh_hz = 0.0;
  unsigned long crtc = 0;  ///< RandR's CRTC that drives the output

  bool on() const { return width > 0 && height > 0; }
};

/// Required colour depth of the X server; with any other depth grey levels are not exact.
constexpr int kExactDepthBits = 24;

/// The output with this name or monitor name. Errc::refused if there are several, Errc::unavailable
/// if there is none; the reason lists the outputs.
Result<const Output*> find_output(const std::vector<Output>& outputs, const std::string& wanted);

/// The output named in the configuration, if it may drive the SLM; else the error of the first
/// failed check.
Result<Output> choose_output(const std::vector<Output>& outputs, const SdlConfig& config);

/// Checks that the output is connected, on, not rotated, and shows the configured size pixel for
/// pixel.
Result<void> check_mode(const Output& output, const SdlConfig& config);

/// The outputs that are connected or on: "DUMMY0 1920x1080 (primary), DUMMY1 1280x768".
std::string list_outputs(const std::vector<Output>& outputs);

/// The monitor's name from the descriptors of an EDID 1.x base block (VESA E-EDID, section 3.10.3);
/// empty if there is none.
std::string edid_monitor_name(std::span<const std::uint8_t> edid);

}  // namespace ovws::sdl
