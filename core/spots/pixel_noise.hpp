/// Noise of camera pixels as a function of their intensity.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace ovws {

/// Noise variance of pixels in DN^2. Shot noise makes it grow with the intensity; the constant part
/// includes read noise and the rounding to whole DN.
struct PixelNoise {
  double constant_dn2 = 1.0;  ///< constant variance of one camera pixel
  double per_dn = 0.0;        ///< variance per DN of intensity, in DN: DN per electron
  /// Saturation: pixels that are expected above 90 % of it are not used.
  double saturated_dn = std::numeric_limits<double>::infinity();

  /// Variance of a binned pixel: the sum of `pixels` camera pixels with `intensity_dn` in total.
  double variance(double intensity_dn, int pixels) const {
    return constant_dn2 * pixels + per_dn * std::max(intensity_dn, 0.0);
  }

  friend bool operator==(const PixelNoise&, const PixelNoise&) = default;
};

}  // namespace ovws
