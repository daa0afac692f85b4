/// Two-beam interferometry on the SLM: measures the phase of a grey level from the fringes of two
/// patches of the pupil.
///
/// Both patches show a binary grating of the base grating's frequency: one with the grey levels 0
/// and g, the other with 0 and a fixed level. The first patch's field at any point of the camera is
/// linear in exp(i phi): M0 + M1 exp(i phi(g)). So is the fringes' complex amplitude (the "beat"),
/// the image's Fourier component at the patches' distance. As g varies, the beat moves on a circle,
/// and its angle about the circle's centre is phi(g), whole turns included. Optics, beam and the
/// rest of the SLM only move, rotate and scale the circle.
///
/// The sign of phi depends on the registration: a camera rotated by 180 degrees sees the opposite,
/// and a binary grating diffracts equally to both sides. A blazed grating does not: only the
/// correct sign brings its light to the camera.
#pragma once

#include <complex>
#include <cstdint>

#include "core/base/image.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"

namespace ovws {

/// Round patches, one to the left and one to the right of the pupil's centre.
struct FringePatches {
  double diameter_px = 0.0;  ///< SLM pixels
  double distance_px = 0.0;  ///< between their centres, SLM pixels
};

/// Chooses the patches. Distance: the largest that the pupil (half its diameter) and the camera (a
/// fringe period of 4 `lit` pixels) allow. Diameter: `share` (0 .. 1) of a subaperture's, but at
/// most half the distance.
FringePatches fringe_patches(const SensorConfig& sensor, const PxPerCycle& map, double share,
                             const LitPixels& lit = {});

/// Draws both patches; the image gets the SLM's size and is 0 outside the patches.
void draw_fringe_patches(const FringePatches& patches, const SensorConfig& sensor,
                         const SlmGeometry& slm, int grey_left, int grey_right,
                         Image<std::uint8_t>& grey);

/// Draws the left patch alone, with a blazed grating of the base grating's frequency through `lut`.
void draw_blazed_patch(const FringePatches& patches, const SensorConfig& sensor,
                       const SlmGeometry& slm, const PhaseLut& lut, Image<std::uint8_t>& grey);

/// The fringes of one camera image.
struct FringeReading {
  std::complex<double> beat;  ///< complex fringe amplitude, DN
  double brightest_dn = 0.0;
  bool saturated = false;  ///< a pixel of the spot is NaN
};

/// Measures the fringes around the base spot at `base_px`, within 1.5 times the radius of the
/// patches' first dark ring. `light`: camera image in DN, NaN where saturated.
FringeReading read_fringe(const Image<float>& light, const FringePatches& patches, Vec2 base_px,
                          const PxPerCycle& map);

}  // namespace ovws
