/// The shape of one spot in the far field of a circular subaperture, for any charge.
#pragma once

namespace ovws {

/// Amplitude at `radius` (units of lambda/d) of a circular aperture that carries charge l:
/// integral_0^1 J_|l|(pi radius s) s ds, not normalised.
double spot_amplitude(int charge, double radius);

/// Its square.
double spot_intensity(int charge, double radius);

/// Radii in units of lambda/d, read off that profile. Charge 0 has no ring: all three ring radii
/// are 0.
struct SpotGeometry {
  double ring = 0.0;        ///< brightest
  double ring_inner = 0.0;  ///< half of the ring's intensity, inside
  double ring_outer = 0.0;  ///< and outside; charge 0: half of the centre's intensity
  double dark = 0.0;        ///< first minimum outside the ring or the bright core
};

/// Takes milliseconds: for constructors, not for the frame path.
SpotGeometry spot_geometry(int charge);

}  // namespace ovws
