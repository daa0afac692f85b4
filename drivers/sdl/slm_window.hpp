/// SLM window: covers one whole output pixel for pixel and is drawn by SDL.
#pragma once

#include <SDL.h>

#include <memory>
#include <string>
#include <utility>

#include "core/port/display.hpp"
#include "drivers/sdl/sdl_display.hpp"
#include "drivers/sdl/video.hpp"

namespace ovws::sdl {

/// Base class of the SLM windows of all display systems. A derived class opens the window and
/// verifies it. Main thread only.
class SlmWindow : public Display {
 public:
  explicit SlmWindow(SdlConfig config) : config_(std::move(config)) {}
  const DisplayInfo& info() const override { return info_; }
  Result<std::int64_t> present(const Image<std::uint8_t>& levels) override;
  Result<void> check() override;

 protected:
  struct Events {
    bool redraw = false;         ///< the window's contents were lost: draw the image again
    bool verify_needed = false;  ///< window or display changed: call `verify` now
  };
  /// Removes all events from the queue and reports what they require.
  virtual Events take_events() = 0;
  /// Checks the connection: error if the connection to the display system broke, or a drawing
  /// request failed since the last call.
  virtual Result<void> connection() = 0;
  /// Verifies the display: error if output, mode or window have changed since opening.
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

/// Opens the SLM window on an X server: output from RandR, window from Xlib, drawing by SDL.
Result<std::unique_ptr<Display>> open_x_window(const SdlConfig& config);

/// Opens the SLM window on Wayland or KMSDRM; finds the output by SDL's display name.
Result<std::unique_ptr<Display>> open_named_window(const std::string& driver,
                                                   const SdlConfig& config);

}  // namespace ovws::sdl
