/// Radial profile of one spot: the far field of a circular subaperture of any charge.
#pragma once

namespace ovws {

/// Far-field amplitude at `radius` (units of lambda/d) of a circular aperture with a vortex of
/// charge l: integral_0^1 J_|l|(pi radius s) s ds, not normalised.
double spot_amplitude(int charge, double radius);

/// Far-field intensity: the square of spot_amplitude.
double spot_intensity(int charge, double radius);

/// Characteristic radii of spot_intensity, units of lambda/d. Charge 0 has no ring: `ring` and
/// `ring_inner` are 0.
struct SpotGeometry {
  double ring = 0.0;        ///< radius of the maximum
  double ring_inner = 0.0;  ///< radius of half the maximum, inner side of the ring
  double ring_outer = 0.0;  ///< radius of half the maximum, outer side of the ring or bright core
  double dark = 0.0;        ///< first minimum outside the ring or the bright core
};

/// The characteristic radii. The first call takes tens of milliseconds: for constructors, not for
/// the frame path. Later calls with charges from -8 to 8 look the radii up. Thread-safe.
SpotGeometry spot_geometry(int charge);

}  // namespace ovws
