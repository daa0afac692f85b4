/// Display output: its description, and checks whether it may drive the SLM.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws::sdl {

struct Output {
  std::string name;     ///< name of the output: "HDMI-1"
  std::string monitor;  ///< monitor name in the EDID; empty: unknown
  bool connected = false;
  bool primary = false;
  int x = 0, y = 0;           ///< top left corner on the desktop, pixels
  int width = 0, height = 0;  ///< area of the desktop, pixels; 0 x 0: switched off
  int mode_width = 0;         ///< video mode, pixels; unequal to width if the desktop is scaled
  int mode_height = 0;
  bool upright = true;       ///< neither rotated nor mirrored
  bool linear_gamma = true;  ///< linear gamma ramp: grey levels are unchanged
  double refresh_hz = 0.0;
  unsigned long crtc = 0;  ///< RandR's CRTC that drives the output

  bool on() const { return width > 0 && height > 0; }
};

/// Required colour depth of the X server; with any other depth grey levels are not exact.
constexpr int kExactDepthBits = 24;

/// Finds the output with this name or monitor name. Errc::refused if several outputs match,
/// Errc::unavailable if none does; the reason lists the outputs.
Result<const Output*> find_output(const std::vector<Output>& outputs, const std::string& wanted);

/// Chooses the output named in the configuration, if it may drive the SLM. Else returns the error
/// of the first failed check.
Result<Output> choose_output(const std::vector<Output>& outputs, const SdlConfig& config);

/// Checks the output's mode: connected, switched on, not rotated, and of the configured size pixel
/// for pixel.
Result<void> check_mode(const Output& output, const SdlConfig& config);

/// List of the outputs that are connected or on: "DUMMY0 1920x1080 (primary), DUMMY1 1280x768".
std::string list_outputs(const std::vector<Output>& outputs);

/// Monitor name from the descriptors of an EDID 1.x base block (VESA E-EDID, section 3.10.3); empty
/// if the EDID has no name.
std::string edid_monitor_name(std::span<const std::uint8_t> edid);

}  // namespace ovws::sdl
