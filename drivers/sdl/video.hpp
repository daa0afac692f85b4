/// SDL's video subsystem and the choice of its driver.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace ovws::sdl {

/// Chooses SDL's video driver: SDL_VIDEODRIVER if it is x11, wayland or KMSDRM, else "x11" or
/// "wayland" by DISPLAY and WAYLAND_DISPLAY. SDL's own search is not used. Without an X server it
/// would choose KMSDRM, which keeps a restarted X server from the screens, or "offscreen", which
/// shows nothing but reports success. Errc::unavailable, field "slm.display", if no driver fits.
Result<std::string> choose_driver();

/// Value of an environment variable; empty if the variable is not set.
std::string environment(const char* name);

/// RAII owner of SDL's video subsystem. At most one object may exist in a process.
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
