/// The noise of camera pixels as a function of their light.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace ovws {

/// Variance in DN^2. Shot noise makes it grow with the intensity; the constant part holds read
/// noise and the rounding to whole DN.
struct PixelNoise {
  double constant_dn2 = 1.0;  ///< of one camera pixel
  double per_dn = 0.0;        ///< DN of variance for each DN of intensity: DN per electron
  double saturated_dn = std::numeric_limits<double>::infinity();  ///< brighter pixels are not used

  /// Variance of a cell of `pixels` camera pixels that holds `intensity_dn` in all.
  double variance(double intensity_dn, int pixels) const {
    return constant_dn2 * pixels + per_dn * std::max(intensity_dn, 0.0);
  }
};

}  // namespace ovws
