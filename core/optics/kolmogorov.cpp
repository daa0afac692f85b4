#include "core/optics/kolmogorov.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {
namespace {

constexpr int kOrders = 8;

/// Kolmogorov variance of a mode of radial order n, up to a common factor.
double variance(int n) {
  return (n + 1) * std::exp(std::lgamma(n - 5.0 / 6.0) - std::lgamma(n + 23.0 / 6.0));
}

}  // namespace

std::vector<Mode> air_modes(int first_j, int last_j) {
  std::vector<Mode> modes;
  double sum = 0.0;
  for (int j = first_j; j <= last_j; ++j) {
    const double of_mode = variance(zernike_index(j).n);
    sum += of_mode;
    modes.push_back({j, std::sqrt(of_mode)});
  }
  for (Mode& mode : modes) mode.waves /= std::sqrt(sum);
  return modes;
}

std::vector<Mode> higher_modes(std::span<const int> modes_j) {
  constexpr int kLastTilt = 2;
  const int highest_j =
      std::max(kLastTilt, modes_j.empty() ? 0 : *std::max_element(modes_j.begin(), modes_j.end()));
  const int last_n = zernike_index(highest_j).n + kOrders;
  return air_modes(highest_j + 1, std::min(kMaxZernikeIndex, osa_index({last_n, last_n})));
}

}  // namespace ovws
