/// SDL's video subsystem, and which of its drivers may show the SLM.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace ovws::sdl {

/// The driver for this environment: SDL_VIDEODRIVER if it names one that shows something, else
/// "x11" or "wayland" by DISPLAY and WAYLAND_DISPLAY. SDL is never left to search: with the X
/// server down it would go on to KMSDRM and keep the screens from the server that comes back, or to
/// "offscreen", which shows nothing and reports success.
Result<std::string> choose_driver();

/// The value of an environment variable, empty if it is not set.
std::string environment(const char* name);

/// Initialised while it lives. One in a process, as SDL has it.
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
