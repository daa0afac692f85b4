/// SDL's video subsystem and the choice of its driver.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace ovws::sdl {

/// SDL's video driver for this environment: SDL_VIDEODRIVER if it is x11, wayland or KMSDRM, else
/// "x11" or "wayland" by DISPLAY and WAYLAND_DISPLAY. SDL's own search is not used: without an X
/// server it would pick KMSDRM, which blocks the screens for a returning server, or "offscreen",
/// which shows nothing and reports success. Errc::unavailable, field "slm.display", if no driver
/// fits.
Result<std::string> choose_driver();

/// The value of an environment variable, empty if it is not set.
std::string environment(const char* name);

/// RAII owner of SDL's video subsystem; at most one in a process.
class Video {
 public:
  static Result<std::unique_ptr<Video>> open(const std::string& driver);
  static bool is_open();
  ~Video();
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

 private:
  Video() = default;
};

}  // namespace ovws::sdl
