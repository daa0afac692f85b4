/// The display port: outputs of the display system, one of which shows the SLM's grey levels or a
/// DMD's bits, pixel for pixel.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct DisplayInfo {
  std::string output;  ///< output name in the display system: "DUMMY1", "HDMI-1", …
  int width = 0, height = 0;
  double refresh_hz = 0.0;
  std::string driver;  ///< "x11", "wayland", "KMSDRM"
};

/// The SLM's settings that can change at run time.
struct SlmSettings {
  std::string display = "DUMMY1";  ///< output name, e.g. "HDMI-1"
  bool allow_primary = false;      ///< the only or the primary output may be the SLM
  double settle_ms = 20.0;         ///< from presenting a hologram until the SLM has settled
  friend bool operator==(const SlmSettings&, const SlmSettings&) = default;
};

/// An output of the display system, open or not.
struct DisplayOutput {
  std::string name;
  std::string monitor;  ///< name of the monitor or SLM; empty: unknown
  bool connected = false, on = false, primary = false;
  int width = 0, height = 0;  ///< video mode, pixels; 0 x 0: off
  double refresh_hz = 0.0;
  std::string reason;     ///< why it cannot be the SLM, and what to do; empty: it can
  bool selected = false;  ///< it is the configured output
};

/// One open display output. Call all methods from the main thread. If `present` or `check` fails,
/// the object is unusable: destroy it and open a new one.
class Display {
 public:
  virtual ~Display() = default;
  virtual const DisplayInfo& info() const = 0;
  /// Shows an image of the size in info(): grey levels, or, three times as wide, the red, green and
  /// blue of each pixel. Returns the time at which the display system accepted the image,
  /// CLOCK_MONOTONIC in ns.
  virtual Result<std::int64_t> present(const Image<std::uint8_t>& levels) = 0;
  /// Waits until the output has begun its next refresh, 0.1 s at most, so that `present` changes
  /// the image early in one. Returns the time of its beginning, CLOCK_MONOTONIC in ns; 0,
  /// at once, where the display system does not tell.
  virtual std::int64_t wait_for_refresh() { return 0; }
  /// Reads back the pixels that the output shows now (0xRRGGBB), whichever program drew them. Takes
  /// tens of milliseconds. Errc::unavailable: the display system gives no image; the object stays
  /// usable. Errc::device: the display was lost; open a new object.
  virtual Result<Image<std::uint32_t>> read_back() = 0;
  /// Handles pending display events and checks that the output, its mode and the window are still
  /// valid. The error says what is wrong.
  virtual Result<void> check() = 0;
};

}  // namespace ovws
