#include "core/optics/zernike_terms.hpp"

#include <cassert>
#include <cstdlib>

#include "core/optics/zernike.hpp"

namespace ovws {
namespace {

double factorial(int n) {
  double product = 1.0;
  for (int k = 2; k <= n; ++k) product *= k;
  return product;
}

ZernikeTerms make_terms(int j) {
  const ZernikeIndex index = zernike_index(j);
  const int m = std::abs(index.m);
  const int half = (index.n - m) / 2;
  ZernikeTerms terms{index.n, index.m, half + 1, {}};
  for (int k = 0; k <= half; ++k) {
    // Term rho^(n-2k) of the radial polynomial R_n^m. It equals rho^m s^(half-k) with s = rho^2.
    const double size =
        factorial(index.n - k) / (factorial(k) * factorial(half + m - k) * factorial(half - k));
    terms.radial[half - k] = zernike_rms_factor(j) * (k % 2 == 0 ? size : -size);
  }
  return terms;
}

}  // namespace

const ZernikeTerms& zernike_terms(int j) {
  static const auto table = [] {
    std::array<ZernikeTerms, kMaxZernikeIndex + 1> all;
    for (int i = 0; i <= kMaxZernikeIndex; ++i) all[i] = make_terms(i);
    return all;
  }();
  assert(j >= 0 && j <= kMaxZernikeIndex);
  return table[j];
}

}  // namespace ovws
