/// Radial profile of one spot: the far field of a circular subaperture of any charge.
#pragma once

namespace ovws {

/// Amplitude at `radius` (units of lambda/d) of a circular aperture that carries charge l:
/// integral_0^1 J_|l|(pi radius s) s ds, not normalised.
double spot_amplitude(int charge, double radius);

/// The square of spot_amplitude.
double spot_intensity(int charge, double radius);

/// Radii in units of lambda/d, read off that profile. Charge 0 has no ring: `ring` and `ring_inner`
/// are 0.
struct SpotGeometry {
  double ring = 0.0;        ///< of the maximum
  double ring_inner = 0.0;  ///< of half the ring's maximum, inner side
  double ring_outer = 0.0;  ///< same, outer side; charge 0: of half the central maximum
  double dark = 0.0;        ///< first minimum outside the ring or the bright core
};

/// Takes milliseconds: for constructors, not for the frame path.
SpotGeometry spot_geometry(int charge);

}  // namespace ovws
