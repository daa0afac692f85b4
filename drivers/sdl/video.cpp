#include "drivers/sdl/video.hpp"

#include <SDL.h>

#include <cstdlib>

namespace ovws::sdl {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

Result<std::string> choose_driver() {
  const std::string wanted = environment("SDL_VIDEODRIVER");
  if (wanted == "x11" || wanted == "wayland" || wanted == "KMSDRM") return wanted;
  if (!wanted.empty()) {
    return fail(Errc::unavailable, "slm.display",
                "SDL_VIDEODRIVER=" + wanted +
                    " does not drive an output: unset it, or set x11, wayland or KMSDRM");
  }
  if (!environment("DISPLAY").empty()) return "x11";
  if (!environment("WAYLAND_DISPLAY").empty()) return "wayland";
  return fail(Errc::unavailable, "slm.display",
              "neither DISPLAY nor WAYLAND_DISPLAY is set: set DISPLAY to the X server that drives "
              "the SLM (or SDL_VIDEODRIVER=KMSDRM on a bench without a desktop)");
}

bool Video::is_open() {
  return SDL_WasInit(SDL_INIT_VIDEO) != 0;
}

Result<std::unique_ptr<Video>> Video::open(const std::string& driver) {
  const char* on_gpu = driver == "x11" ? "0" : "1";
  SDL_SetHintWithPriority(SDL_HINT_VIDEODRIVER, driver.c_str(), SDL_HINT_OVERRIDE);
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");  // the daemon handles SIGTERM
  // On X draw by shared memory without the GPU: pixels are exact, and drawing is complete when the
  // call returns. A GPU driver would queue frames, start threads, and hang when the server ends. On
  // Wayland and KMSDRM, SDL offers only the GPU path, which waits for the vertical blank.
  SDL_SetHintWithPriority(SDL_HINT_FRAMEBUFFER_ACCELERATION, on_gpu, SDL_HINT_OVERRIDE);
  SDL_SetHintWithPriority(SDL_HINT_RENDER_VSYNC, on_gpu, SDL_HINT_OVERRIDE);
  if (SDL_InitSubSystem(SDL_INIT_VIDEO) != 0) {
    return fail(Errc::unavailable, "slm.display",
                "SDL cannot use its driver " + driver + " (" + SDL_GetError() +
                    "): check that the desktop session runs and admits the daemon's user");
  }
  SDL_DisableScreenSaver();  // also keeps DPMS from powering the screens down
  return std::unique_ptr<Video>(new Video);
}

Video::~Video() {
  SDL_QuitSubSystem(SDL_INIT_VIDEO);
}

}  // namespace ovws::sdl
