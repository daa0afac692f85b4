/// The port of the SLM: an output that shows grey levels, pixel for pixel.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct DisplayInfo {
  std::string output;  ///< "DUMMY1", "HDMI-1", …: the name the display system gives it
  int width = 0, height = 0;
  double refresh_hz = 0.0;
  std::string driver;  ///< "x11", "wayland", "KMSDRM"
};

/// One opened output. All calls from the main thread. After an error, but for those of `read_back`,
/// the object is dead: destroy it, open a new one.
class Display {
 public:
  virtual ~Display() = default;
  virtual const DisplayInfo& info() const = 0;
  /// Shows the picture (width and height as in info) and returns when the display system took it:
  /// CLOCK_MONOTONIC ns.
  virtual Result<std::int64_t> present(const Image<std::uint8_t>& grey) = 0;
  /// What stands on the output now, 0xRRGGBB, whoever drew it; tens of milliseconds.
  /// Errc::unavailable where the display system lets nobody see that; the object then lives on.
  virtual Result<Image<std::uint32_t>> read_back() = 0;
  /// Handles the display system's events and checks output, mode and window. An error says what is
  /// wrong.
  virtual Result<void> check() = 0;
};

}  // namespace ovws
