/// Window that covers one whole output pixel for pixel, and can verify that it still does.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "core/port/display.hpp"
#include "drivers/sdl/sdl_display.hpp"

struct SDL_Window;

namespace ovws::sdl {

/// Main thread only.
class OutputWindow {
 public:
  virtual ~OutputWindow() = default;
  virtual const DisplayInfo& info() const = 0;
  virtual SDL_Window* window() const = 0;

  struct Events {
    bool redraw = false;         ///< the window's contents were lost: draw again
    bool verify_needed = false;  ///< something changed: verify now
  };
  /// Drains the event queue, so that events do not pile up.
  virtual Events take_events() = 0;
  /// Error if the connection to the display system broke, or a drawing request failed since the
  /// last call.
  virtual Result<void> connection() = 0;
  /// As Display::read_back.
  virtual Result<Image<std::uint32_t>> read_back() = 0;
  /// Error if output, mode or window have changed since opening.
  virtual Result<void> verify() = 0;
};

/// On an X server: finds the output by RandR, creates the window by Xlib, and draws by SDL.
Result<std::unique_ptr<OutputWindow>> open_x_window(const SdlConfig& config);

/// On Wayland and KMSDRM: finds the output by SDL's display name.
Result<std::unique_ptr<OutputWindow>> open_named_window(const std::string& driver,
                                                        const SdlConfig& config);

}  // namespace ovws::sdl
