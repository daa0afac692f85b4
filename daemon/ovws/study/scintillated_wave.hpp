/// Light that has passed a layer of turbulent air far away: phase and amplitude vary over the
/// pupil.
#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"

namespace ovws::study {

constexpr int kWavePx = 512;         ///< width and height of a simulated wave, which is periodic
constexpr double kPupilPx = 256.0;   ///< diameter of the pupil in its centre
constexpr double kOuterScale = 2.0;  ///< of the turbulence, pupil diameters

/// One thin layer with von Karman's spectrum. By its distance z, light of wavelength lambda comes
/// with the Rytov variance 1.145 (sqrt(lambda z) / r0)^(5/3), the intensity's variance while weak.
struct Air {
  double pupils_per_r0 = 0.0;   ///< D / r0
  double rytov_variance = 0.0;  ///< 0: the layer is at the pupil, and changes only the phase
};

using Wave = Image<std::complex<float>>;

/// The wave at the pupil, by Fresnel propagation (angular spectrum) from the layer; its mean
/// intensity is 1. The same seed gives the same wave.
Wave scintillated_wave(const Air& air, std::uint64_t seed);
/// Variance of the intensity over the pupil, relative to the square of its mean.
double scintillation_index(const Wave& wave);

/// Every second pixel of the pupil, in each direction.
struct PupilPixel {
  int x = 0, y = 0;
  Vec2 at;  ///< pupil radii
};
std::vector<PupilPixel> pupil_pixels();

}  // namespace ovws::study
