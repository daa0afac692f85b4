/// Pattern mode of a DMD: it shows the bits of each RGB image one after the other, and pulses the
/// camera's trigger at the start of each.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/dmd.hpp"

namespace ovws::twin {

struct PatternMode {
  int patterns = 0;  ///< per cycle, 2 to 24; 0: video mode
  BitOrder bit_order = BitOrder::grb;
  double cycle_ms = 1000.0 / 60.0;

  friend bool operator==(const PatternMode&, const PatternMode&) = default;
};

/// What the modulator shows of one display image: the grey levels, or in pattern mode one binary
/// image (0 or 255) for each pattern. All have the modulator's size.
using Patterns = std::vector<Image<std::uint8_t>>;

/// Patterns of a black display.
Patterns dark_patterns(const PatternMode& dmd, int width, int height);
/// Reads row `y` of a display image, pixels 0x00RRGGBB, into `patterns`.
void read_row(const PatternMode& dmd, const std::uint32_t* pixels, int y, Patterns& patterns);
bool same_pixels(const Patterns& a, const Patterns& b);

/// Patterns that one frame shows: `count` in turn from `first` on, for equal times.
struct Exposed {
  int first = 0, count = 1;

  friend bool operator==(const Exposed&, const Exposed&) = default;
};

/// Schedule of the pattern mode: pulse number n comes at n periods since the UNIX epoch (UTC) and
/// begins pattern n modulo `patterns`. Immutable.
class PatternClock {
 public:
  explicit PatternClock(const PatternMode& dmd);

  double period_ns() const { return period_ns_; }
  std::int64_t time_of(std::int64_t pulse) const;    ///< UTC, ns
  std::int64_t last_pulse(std::int64_t t_ns) const;  ///< the newest one at this time
  int pattern_of(std::int64_t pulse) const { return int(pulse % patterns_); }
  std::int64_t cycle_of(std::int64_t pulse) const { return pulse / patterns_; }
  /// Begin of the first cycle after this time, UTC, ns.
  std::int64_t next_cycle(std::int64_t t_ns) const;

  /// The newest pulse at the end of an exposure that begins at `t_ns`.
  std::int64_t last_pulse_in(std::int64_t t_ns, double exposure_us) const;
  /// What such an exposure shows: each pattern that it overlaps, or all from a whole cycle on.
  Exposed exposed(std::int64_t t_ns, double exposure_us) const;

 private:
  int patterns_;
  double period_ns_;
};

}  // namespace ovws::twin
