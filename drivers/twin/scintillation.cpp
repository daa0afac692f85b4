#include "drivers/twin/scintillation.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "core/base/angle.hpp"

namespace ovws::twin {

Eigen::MatrixXf amplitude_screen(const ScintillationConfig& scintillation, const PupilLine& x,
                                 const PupilLine& y) {
  constexpr int kWaves = 400;
  // exp(2 chi) with a Gaussian chi has the variance exp(4 s^2) - 1, relative to its mean.
  const double s2 = std::log1p(scintillation.variance) / 4.0;
  // Gaussian frequencies of this deviation, cycles per radius, give the Gaussian correlation.
  const double deviation =
      1.0 / (std::numbers::sqrt2 * std::numbers::pi * 2.0 * scintillation.scale_pupils);
  const double amplitude = std::sqrt(2.0 * s2 / kWaves);
  std::mt19937_64 random{std::uint64_t(scintillation.seed)};
  const auto uniform = [&random] { return (double(random() >> 11) + 0.5) * 0x1.0p-53; };
  Eigen::MatrixXf along_x(x.count, 2 * kWaves), along_y(y.count, 2 * kWaves);
  for (int k = 0; k < kWaves; ++k) {
    // Box-Muller transform, so that a seed gives the same screen with any library.
    const double length = deviation * std::sqrt(-2.0 * std::log(uniform()));
    const double direction = kTwoPi * uniform(), start = kTwoPi * uniform();
    const double fx = kTwoPi * length * std::cos(direction);
    const double fy = kTwoPi * length * std::sin(direction);
    for (int n = 0; n < x.count; ++n) {
      along_x(n, 2 * k) = float(amplitude * std::cos(fx * x.at(n)));
      along_x(n, 2 * k + 1) = float(-amplitude * std::sin(fx * x.at(n)));
    }
    for (int n = 0; n < y.count; ++n) {
      along_y(n, 2 * k) = float(std::cos(fy * y.at(n) + start));
      along_y(n, 2 * k + 1) = float(std::sin(fy * y.at(n) + start));
    }
  }
  return ((along_x * along_y.transpose()).array() - float(s2)).exp();
}

}  // namespace ovws::twin
