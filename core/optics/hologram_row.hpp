/// SIMD loops over a row of a hologram (Highway library): phase of the modes, and look-up of the
/// grey levels. All instruction sets give bit-identical results.
#pragma once

#include <cstdint>
#include <span>

namespace ovws {

/// Maximum number of coefficients of the polynomial that gives the modes' phase along a row.
constexpr int kMaxPhasePowers = 21;
/// Number of extra elements that `mirrored_phases` may access beyond the ends of its arrays.
constexpr int kSparePixels = 32;

/// Evaluates a polynomial at mirrored pixels: right[k] and left[-k], k = 0 .. count - 1, are the
/// phase16 (phasors.hpp) of its value at x[k] and -x[k]. Each pair needs only one sum of even and
/// one of odd powers. `waves`: 1 to kMaxPhasePowers coefficients by rising power. As accurate as a
/// power sum in double precision.
void mirrored_phases(std::span<const double> waves, const double* x, int count,
                     std::uint16_t* right, std::uint16_t* left);

/// Looks up grey levels: grey = lut[top 8 bits of (base + added) modulo 65536] for `count` pixels.
/// `lut` has 256 levels.
void look_up_greys(const std::uint16_t* base, const std::uint16_t* added, const std::uint8_t* lut,
                   int count, std::uint8_t* grey);

/// DMD: grey = 255 where the distance of (base + added) from 0, modulo 65536, is below the pixel's
/// limit, else 0.
void switch_mirrors(const std::uint16_t* base, const std::uint16_t* added,
                    const std::uint16_t* limits, int count, std::uint8_t* grey);

}  // namespace ovws
