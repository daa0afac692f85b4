/// Shared helpers of the display tests: configuration, test images, and reading of the X server's
/// pixels.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/image.hpp"
#include "core/port/display.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws::test {

/// The SLM of drivers/twin/xorg-bench.conf: 1280x768 on DUMMY1, at +1920+0.
inline SdlConfig slm_config() {
  return {.output = "DUMMY1", .width = 1280, .height = 768, .allow_primary = false};
}
constexpr int kSlmX = 1920;

/// Opens the display. On error fails the test with the reason and returns null.
std::unique_ptr<Display> open_or_fail(const SdlConfig& config = slm_config());

Image<std::uint8_t> random_image(unsigned seed, int width = 1280, int height = 768);

/// Number of pixels of the desktop at (x, y) that differ from the image's grey levels, as seen by
/// another client of the X server. All pixels if the server does not answer.
int wrong_pixels(const Image<std::uint8_t>& picture, int x = kSlmX, int y = 0);

/// Calls check() as often as every 10 ms in `seconds`, or until it returns an error; returns the
/// error's reason, or "".
std::string watch(Display& display, double seconds);

/// Runs a shell command, and fails the test if its status is not 0.
void run(const std::string& command);

/// A line of /proc/self/status as a number, e.g. "VmRSS" (kB) or "Threads".
long process_status(const std::string& key);

}  // namespace ovws::test
