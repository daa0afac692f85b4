/// A window that covers one whole output, pixel for pixel, and knows whether it still does.
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
    bool redraw = false;  ///< the display system forgot the picture
    bool look = false;    ///< something changed: verify now
  };
  /// Takes all waiting events, so that none pile up.
  virtual Events take_events() = 0;
  /// Whether the display system still answers, and refused nothing that was drawn since the last
  /// call.
  virtual Result<void> connection() = 0;
  /// As Display::read_back.
  virtual Result<Image<std::uint32_t>> read_back() = 0;
  /// Whether output, mode and window are as they were when it was opened.
  virtual Result<void> verify() = 0;
};

/// On an X server: the output is found by RandR, the window is our own and SDL draws into it.
Result<std::unique_ptr<OutputWindow>> open_x_window(const SdlConfig& config);

/// On Wayland and KMSDRM: the output is found by the name that SDL gives it.
Result<std::unique_ptr<OutputWindow>> open_named_window(const std::string& driver,
                                                        const SdlConfig& config);

}  // namespace ovws::sdl
