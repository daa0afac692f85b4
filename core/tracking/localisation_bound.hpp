/// How well any unbiased method can place a spot: the Cramer-Rao bound.
#pragma once

#include "core/base/vec2.hpp"
#include "core/tracking/spot_shape.hpp"

namespace ovws {

/// What the camera sees of a spot, in electrons.
struct SpotExposure {
  double peak_e = 500.0;      ///< mean at the shape's value 1
  double background_e = 0.0;  ///< mean, under the whole window
  double read_noise_e = 5.0;  ///< RMS of what does not depend on the light
};

/// RMS of one axis (root of the mean of both axes' variances), camera pixels.
struct LocalisationBound {
  double px = 0.0;        ///< amplitude and background unknown, as they are to a tracker
  double px_known = 0.0;  ///< both known
};

/// The bound over the square window of pixels within `half_px` of the pixel nearest to `centre`, of
/// a spot at `centre`. The noise is taken as Gaussian of variance I + sigma^2 (shot noise of many
/// electrons, and read noise), and only the mean as telling of the position: Fisher information
/// sum over pixels of (dI/da)(dI/db) / (I + sigma^2). Infinite if the window does not tell.
LocalisationBound localisation_bound(const SpotShape& shape, Vec2 centre, int half_px,
                                     const SpotExposure& exposure);

}  // namespace ovws
