#include "tests/contract/display/bench.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <thread>

// Last: Xlib has macros like None that would break the others.
#include <X11/Xlib.h>
#include <X11/Xutil.h>

#if defined(__SANITIZE_ADDRESS__)
// SDL asks the session bus to hold off the screen saver; libdbus loses one buffer if there is none.
// NOLINTNEXTLINE(bugprone-reserved-identifier): the sanitizer's own hook
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libdbus";
}
#endif

namespace ovws::test {

std::unique_ptr<Display> open_or_fail(const SdlConfig& config) {
  auto display = open_sdl_display(config);
  if (display) return std::move(*display);
  ADD_FAILURE() << display.error().field << ": " << display.error().reason;
  return nullptr;
}

Image<std::uint8_t> random_image(unsigned seed, int width, int height) {
  std::mt19937 random(seed);
  Image<std::uint8_t> picture(width, height);
  for (auto& pixel : picture.pixels) pixel = static_cast<std::uint8_t>(random());
  return picture;
}

int wrong_pixels(const Image<std::uint8_t>& picture, int x, int y) {
  int wrong = picture.width * picture.height;
  ::Display* server = XOpenDisplay(nullptr);
  if (server == nullptr) return wrong;
  XImage* seen = XGetImage(server, DefaultRootWindow(server), x, y, unsigned(picture.width),
                           unsigned(picture.height), AllPlanes, ZPixmap);
  if (seen != nullptr) {
    for (int v = 0; v < picture.height; ++v) {
      for (int u = 0; u < picture.width; ++u) {
        const unsigned long grey = picture.at(u, v);
        if ((XGetPixel(seen, u, v) & 0xffffff) == grey * 0x010101) --wrong;
      }
    }
    XDestroyImage(seen);
  }
  XCloseDisplay(server);
  return wrong;
}

std::string watch(Display& display, double seconds) {
  for (int left = int(std::lround(100.0 * seconds)); left > 0; --left) {
    if (const auto checked = display.check(); !checked) return checked.error().reason;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return "";
}

void run(const std::string& command) {
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

long process_status(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key + ":")) return std::atol(line.c_str() + key.size() + 1);
  }
  return -1;
}

}  // namespace ovws::test
