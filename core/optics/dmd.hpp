/// Digital micromirror device (DMD): binary amplitude (Lee) holograms.
///
/// A mirror is on where the wrapped phase is within duty / 2 waves of 0. Its transmission is the
/// Fourier series sum over m of sin(pi m duty) / (pi m) exp(2 pi i m phase), so the diffraction
/// order m = 1 has the phase of an SLM's hologram and the amplitude sin(pi duty) / pi.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// Order in which a DMD in its pattern mode plays the colours of a pixel, each from bit 0 to 7.
enum class BitOrder { grb, rgb, bgr };

/// Binary images in one frame of the video input at most: the bits of a pixel.
constexpr int kMaxPatternSlots = 24;

struct DmdConfig {
  /// Fraction by which the amplitude falls from a subaperture's centre to its rim, 0 to 1: at r
  /// radii it is 1 - apodisation r^2.
  double apodisation = 0.0;
  /// Amplitude of each subaperture, above 0 to 1, in the lattice's order; empty: 1 for all.
  std::vector<double> amplitudes{};
  /// Pattern mode: number of bits of each pixel that the DMD plays as binary images, one after the
  /// other, in each frame of the video input. 0: it shows grey levels, without a pattern mode.
  int slots = 0;
  BitOrder bit_order = BitOrder::grb;  ///< in which it plays them

  friend bool operator==(const DmdConfig&, const DmdConfig&) = default;
};

/// Duty whose first order has this amplitude relative to duty 1/2, which has the most: 0 to 1/2.
double duty_of(double amplitude);

/// Limit of |phase|, 65536 per wave, below which a mirror is on (switch_mirrors), for a duty up to
/// 1/2. 0: always off.
std::uint16_t mirror_limit(double duty);

/// Limits of row y of the sensor's hologram; `limits` has the width of the DMD. Mirrors outside the
/// subapertures are off.
void sensor_limits_row(const DmdConfig& dmd, const Lattice& lattice, const SlmGeometry& slm, int y,
                       std::vector<std::uint16_t>& limits);

/// Adds the mirrors that are on in `mirrors` (levels from 128) to the image that a DMD plays number
/// `slot`, 0 to kMaxPatternSlots - 1. `rgb` has three bytes a pixel: red, green and blue.
void add_pattern(const Image<std::uint8_t>& mirrors, int slot, BitOrder order,
                 Image<std::uint8_t>& rgb);

/// Checks the number of amplitudes, and that the orders 0, -1, 3 and -3 of every subaperture, as
/// the mirrors' pitch aliases them, are two lambda/d or more from every spot; with a duty below 1/2
/// the orders 2 and -2 as well. Errors (Errc::invalid) name dmd.amplitudes or sensor.grooves.
Result<void> check_dmd(const DmdConfig& dmd, const Lattice& lattice);

}  // namespace ovws
