/// Affine map between spatial frequencies and camera pixels.
#pragma once

#include "core/base/vec2.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// Affine map from spatial frequency u to camera pixels: pixel = centre + S R M (u - u_base), x
/// right, y down. u is in cycles per SLM pixel; u_base is the frequency of the base grating; S is
/// camera_px_per_cycle. M mirrors first: "x" changes the sign of the x component, "y" that of the y
/// component. R then rotates; a positive angle turns +x towards +y.
struct CameraMap {
  Vec2 centre_px;    ///< pixel of u_base, relative to the sensor or (relative_to) a window
  Vec2 base_cpp;     ///< u_base, cycles per SLM pixel
  double scale = 0;  ///< S, camera pixels per unit of frequency
  Vec2 of_x, of_y;   ///< R M (1, 0) and R M (0, 1); exactly 0 and +-1 at multiples of 90 degrees

  Vec2 pixel(Vec2 cpp) const;
  Vec2 frequency(Vec2 px) const;
  /// Camera map with pixels counted from `corner_px`, the corner of a window.
  CameraMap relative_to(Vec2 corner_px) const;
  bool axis_aligned() const;  ///< whether the rotation is a multiple of 90 degrees
};

/// Camera map for this camera geometry, of a plane in which `base` falls on centre_px and a unit is
/// `scale` camera pixels long.
CameraMap camera_map(const CameraGeometry& geometry, Vec2 base, double scale);
/// Camera map of the SLM bench for this camera geometry. Wavelength, focal length, pixel pitches
/// and base grating come from `config`.
CameraMap camera_map(const Config& config, const CameraGeometry& geometry);

}  // namespace ovws::twin
