/// Cartesian polynomial form of the Zernike modes, computed once: Z = q(x^2 + y^2) times Re or Im
/// of (x + i y)^|m|. This form needs no angle and has no singularity at the centre.
#pragma once

#include <array>

namespace ovws {

struct ZernikeTerms {
  int n = 0;
  int m = 0;                        ///< m < 0: imaginary part (sine), else real part (cosine)
  int count = 0;                    ///< terms in use: (n - |m|)/2 + 1
  std::array<double, 11> radial{};  ///< q(s) = sum radial[k] s^k, RMS factor included
};

/// Terms of mode j from a table. Requires 0 <= j <= kMaxZernikeIndex. Thread-safe.
const ZernikeTerms& zernike_terms(int j);

}  // namespace ovws
