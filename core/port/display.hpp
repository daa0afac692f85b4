/// The display port: an output that shows the SLM's grey levels, pixel for pixel.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct DisplayInfo {
  std::string output;  ///< "DUMMY1", "HDMI-1", …: the name in the display system
  int width = 0, height = 0;
  double refresh_hz = 0.0;
  std::string driver;  ///< "x11", "wayland", "KMSDRM"
};

/// One open output. All calls come from the main thread. After an error of any call but `read_back`
/// the object is dead: destroy it and open a new one.
class Display {
 public:
  virtual ~Display() = default;
  virtual const DisplayInfo& info() const = 0;
  /// Shows an image of the size in info(). Returns the time at which the display system accepted
  /// it, CLOCK_MONOTONIC ns.
  virtual Result<std::int64_t> present(const Image<std::uint8_t>& grey) = 0;
  /// Reads back what the output shows now, 0xRRGGBB, whichever program drew it; takes tens of
  /// milliseconds. Errc::unavailable if the display system does not support it or gives no image;
  /// the object stays usable. Errc::device if the display was lost: open it again.
  virtual Result<Image<std::uint32_t>> read_back() = 0;
  /// Handles pending display events and checks output, mode and window. The error says what is
  /// wrong.
  virtual Result<void> check() = 0;
};

}  // namespace ovws
