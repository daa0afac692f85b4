/// Display whose window covers one whole output pixel for pixel, drawn by SDL.
#pragma once

#include <SDL.h>

#include <memory>
#include <string>
#include <utility>

#include "core/port/display.hpp"
#include "drivers/sdl/sdl_display.hpp"
#include "drivers/sdl/video.hpp"

namespace ovws::sdl {

/// What all display systems share; a derived class opens the window and verifies it. Main thread
/// only.
class SlmWindow : public Display {
 public:
  explicit SlmWindow(SdlConfig config) : config_(std::move(config)) {}
  const DisplayInfo& info() const override { return info_; }
  Result<std::int64_t> present(const Image<std::uint8_t>& grey) override;
  Result<void> check() override;

 protected:
  struct Events {
    bool redraw = false;         ///< the window's contents were lost: draw again
    bool verify_needed = false;  ///< something changed: verify now
  };
  /// Drains the event queue, so that events do not pile up.
  virtual Events take_events() = 0;
  /// Error if the connection to the display system broke, or a drawing request failed since the
  /// last call.
  virtual Result<void> connection() = 0;
  /// Error if output, mode or window have changed since opening.
  virtual Result<void> verify() = 0;

  static Error changed(const std::string& reason) { return {Errc::device, "slm.display", reason}; }

  struct DestroyWindow {
    void operator()(SDL_Window* window) const { SDL_DestroyWindow(window); }
  };

  SdlConfig config_;
  DisplayInfo info_;
  std::unique_ptr<Video> video_;
  std::unique_ptr<SDL_Window, DestroyWindow> canvas_;

 private:
  Result<void> flush();

  std::int64_t verify_at_ns_ = 0;
};

/// On an X server: finds the output by RandR, creates the window by Xlib, and draws by SDL.
Result<std::unique_ptr<Display>> open_x_window(const SdlConfig& config);

/// On Wayland and KMSDRM: finds the output by SDL's display name.
Result<std::unique_ptr<Display>> open_named_window(const std::string& driver,
                                                   const SdlConfig& config);

}  // namespace ovws::sdl
