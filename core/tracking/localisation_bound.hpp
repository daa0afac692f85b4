/// The Cramer-Rao bound of spot localisation.
#pragma once

#include "core/base/vec2.hpp"
#include "core/tracking/spot_shape.hpp"

namespace ovws {

/// Exposure of a spot, in electrons.
struct SpotExposure {
  double peak_e = 500.0;      ///< mean signal where the shape's value is 1
  double background_e = 0.0;  ///< mean per pixel, over the whole window
  double read_noise_e = 5.0;  ///< RMS of the noise that does not depend on the signal
};

/// RMS error per axis (root of the mean of both axes' variances), camera pixels.
struct LocalisationBound {
  double px = 0.0;        ///< amplitude and background unknown, as for a tracker
  double px_known = 0.0;  ///< both known
};

/// The bound for a spot at `centre`, from the square of pixels within `half_px` of the pixel
/// nearest to `centre`. The noise is Gaussian of variance I + sigma^2 (shot noise of many
/// electrons, and read noise). Only the mean carries information, so that the Fisher information is
/// the sum over pixels of (dI/da)(dI/db) / (I + sigma^2). Infinite if this matrix is singular.
LocalisationBound localisation_bound(const SpotShape& shape, Vec2 centre, int half_px,
                                     const SpotExposure& exposure);

}  // namespace ovws
