/// Two-beam interferometry on the SLM: measures the phase of a grey level from the fringes of two
/// patches of the pupil.
///
/// Both patches show a binary grating of the base grating's frequency: one with the grey levels 0
/// and g, the other with 0 and a fixed level. The first patch's field at any point of the camera is
/// M0 + M1 exp(i phi(g)), linear in exp(i phi). The fringes' complex amplitude (the "beat") is the
/// image's Fourier component at the patches' distance, and is linear in exp(i phi), too. As g
/// varies, the beat moves on a circle. Its angle about the circle's centre is phi(g), including
/// whole turns. Optics, beam and other SLM pixels only move, rotate and scale the circle.
///
/// The fringes alone do not give the sign of phi: a camera rotated by 180 degrees sees the opposite
/// sign, and a binary grating diffracts equally to both sides. A blazed grating resolves the sign:
/// only the correct sign diffracts to the camera.
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
  double distance_px = 0.0;  ///< between the centres of the patches, SLM pixels
};

/// Chooses distance and diameter of the patches. The distance is half the pupil diameter, or less
/// if the fringe period would be below 4 of the camera pixels that `lit` describes. The diameter is
/// `share` (0 .. 1) times a subaperture's diameter, but at most half the distance.
FringePatches fringe_patches(const SensorConfig& sensor, const PxPerCycle& map, double share,
                             const LitPixels& lit = {});

/// Draws both patches with binary gratings of the levels 0 and grey_left, 0 and grey_right. Resizes
/// `grey` to the SLM's size; pixels outside the patches are 0.
void draw_fringe_patches(const FringePatches& patches, const SensorConfig& sensor,
                         const SlmGeometry& slm, int grey_left, int grey_right,
                         Image<std::uint8_t>& grey);

/// Draws only the left patch, with a blazed grating of the base grating's frequency. `lut` converts
/// phase to grey level.
void draw_blazed_patch(const FringePatches& patches, const SensorConfig& sensor,
                       const SlmGeometry& slm, const PhaseLut& lut, Image<std::uint8_t>& grey);

/// Fringe measurement of one camera image.
struct FringeReading {
  std::complex<double> beat;  ///< complex fringe amplitude, DN
  double brightest_dn = 0.0;
  bool saturated = false;  ///< a pixel of the spot is saturated (NaN)
};

/// Measures the fringes around the base spot at `base_px`, within 1.5 times the radius of the
/// patches' first dark ring. `light`: camera image in DN, NaN where saturated.
FringeReading read_fringe(const Image<float>& light, const FringePatches& patches, Vec2 base_px,
                          const PxPerCycle& map);

/// The map of a camera that was not registered, as far as read_fringe needs it: the rotation of
/// `scale`, in steps of 1 degree, whose beat in this image is the largest. It may be off by 180
/// degrees, or be a reflection instead, neither of which the fringes tell.
PxPerCycle find_fringe_rotation(const Image<float>& light, const FringePatches& patches,
                                Vec2 base_px, double scale);

}  // namespace ovws
