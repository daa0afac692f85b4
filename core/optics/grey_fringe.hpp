/// Two patches of the pupil that beat with each other: pictures for the SLM, and the fringe that
/// the camera sees of them. How the phase of a grey level is measured.
///
/// Both patches show a binary grating of the base grating's frequency, the one of the grey levels 0
/// and g, the other of 0 and a fixed level. The light of the first at any place of the camera is
/// M0 + M1 exp(i phi(g)), linear in exp(i phi): so is its beat with the second one's, which is the
/// camera picture's Fourier component at the patches' distance. Over all g the beat runs along a
/// circle, and the angle about the circle's middle is phi(g), whole turns included, whatever the
/// optics, the beam and the rest of the SLM add. Its sign counts with the camera's map: a camera
/// turned by half a turn sees the opposite, and a binary grating is alike to both sides. A blazed
/// one is not: it tells the sign that brings the light to the camera.
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
  double distance_px = 0.0;  ///< of their middles
};

/// As wide apart as the pupil and the camera allow: half a pupil, or a fringe of four `lit` camera
/// pixels. `share` of a subaperture's diameter, 0 .. 1, but no more than half the distance.
FringePatches fringe_patches(const SensorConfig& sensor, const PxPerCycle& map, double share,
                             const LitPixels& lit = {});

/// Grey levels of slm.width_px x slm.height_px: 0 outside the patches.
void draw_fringe_patches(const FringePatches& patches, const SensorConfig& sensor,
                         const SlmGeometry& slm, int grey_left, int grey_right,
                         Image<std::uint8_t>& grey);

/// The left patch alone, with a grating of the base grating's frequency blazed by `lut`.
void draw_blazed_patch(const FringePatches& patches, const SensorConfig& sensor,
                       const SlmGeometry& slm, const PhaseLut& lut, Image<std::uint8_t>& grey);

/// What the camera's picture says of the beat.
struct FringeReading {
  std::complex<double> beat;  ///< DN
  double brightest_dn = 0.0;
  bool saturated = false;  ///< a pixel of the spot is not a number
};

/// Around the base spot at `base_px`, as far as the patches' first dark ring and half as much
/// again.
FringeReading read_fringe(const Image<float>& light, const FringePatches& patches, Vec2 base_px,
                          const PxPerCycle& map);

}  // namespace ovws
