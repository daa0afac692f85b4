/// How bright the camera's images are, for people who search for the reason of missing spots.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "core/base/image.hpp"

namespace ovws {

/// Grey level that the 16 brightest pixels reach, as a fraction of full scale, within 0.001; a few
/// hot pixels do not count. Reads every pixel.
double brightest_fraction(const ImageView& image);

/// What to do about an image that is dark; see is_dark.
std::string dark_text(double fraction);

/// The brightness of the newest image that was looked at. Thread-safe.
class ImageBrightness {
 public:
  /// `now_ns`: CLOCK_MONOTONIC.
  void look(const ImageView& image, std::int64_t now_ns);
  /// See brightest_fraction. None if no image was looked at in the last three seconds.
  std::optional<double> newest(std::int64_t now_ns) const;

 private:
  std::atomic<double> fraction_{0.0};
  std::atomic<std::int64_t> t_ns_{std::numeric_limits<std::int64_t>::min()};
};

}  // namespace ovws
