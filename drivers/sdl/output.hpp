/// An output of the display system as data, and the decision whether it may carry the SLM.
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
  std::string monitor;  ///< name in the monitor's EDID, empty if it gives none
  bool connected = false;
  bool primary = false;
  int x = 0, y = 0;           ///< its corner on the desktop, pixels
  int width = 0, height = 0;  ///< what it shows of the desktop, pixels; 0 x 0: switched off
  int mode_width = 0;         ///< what it sends to the device; differs if the desktop is scaled
  int mode_height = 0;
  bool upright = true;       ///< neither rotated nor mirrored
  bool linear_gamma = true;  ///< grey levels pass unchanged
  double refresh_hz = 0.0;
  unsigned long crtc = 0;  ///< the display system's handle of what drives it

  bool on() const { return width > 0 && height > 0; }
};

/// Of the display system: with any other grey levels would not be exact.
constexpr int kExactDepthBits = 24;

/// The output with this name, or whose monitor has it. Errc::refused: more than one has it;
/// Errc::unavailable: none has; the reason lists those there are.
Result<const Output*> find_output(const std::vector<Output>& outputs, const std::string& wanted);

/// The output that the configuration names, if it may carry the SLM.
Result<Output> choose_output(const std::vector<Output>& outputs, const SdlConfig& config);

/// Whether the output is connected, on, upright and shows the configured size pixel for pixel.
Result<void> check_mode(const Output& output, const SdlConfig& config);

/// "DUMMY0 1920x1080 (primary), DUMMY1 1280x768": those that are connected or on.
std::string list_outputs(const std::vector<Output>& outputs);

/// The monitor's name from the descriptors of an EDID 1.x base block (VESA E-EDID, section 3.10.3);
/// empty if there is none.
std::string edid_monitor_name(std::span<const std::uint8_t> edid);

}  // namespace ovws::sdl
