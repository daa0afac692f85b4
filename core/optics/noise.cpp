#include "core/optics/noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ovws {
namespace {

constexpr int kQuantiles = 65536;

/// The normal quantiles at (k + 1/2) / kQuantiles, scaled to a variance of exactly 1.
std::vector<float> make_normals() {
  std::vector<double> upper;
  double sum_of_squares = 0.0;
  double z = 0.0;
  for (int k = 0; k < kQuantiles / 2; ++k) {
    const double above_mean = (k + 0.5) / kQuantiles;
    // Newton's method from the previous quantile converges from below, because the density falls.
    for (int step = 0; step < 6; ++step) {
      const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
      z += (above_mean - 0.5 * std::erf(z / std::numbers::sqrt2)) / density;
    }
    upper.push_back(z);
    sum_of_squares += 2.0 * z * z;
  }
  const double scale = std::sqrt(kQuantiles / sum_of_squares);
  std::vector<float> normals;
  for (const double value : upper) {
    normals.push_back(static_cast<float>(scale * value));
    normals.push_back(static_cast<float>(-scale * value));
  }
  return normals;
}

}  // namespace

Noise::PoissonTable::PoissonTable(double mean) {
  double probability = std::exp(-mean);
  double sum = 0.0;
  for (int count = 0; count < kCounts; ++count) {
    sum += probability;
    cumulative[std::size_t(count)] =
        static_cast<std::uint32_t>(std::lround(std::min(sum, 1.0) * kOne));
    probability *= mean / (count + 1.0);
  }
  cumulative.back() = kOne;
  for (std::uint32_t byte = 0; byte < start.size(); ++byte) {
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), byte << 23);
    start[byte] = static_cast<std::uint8_t>(found - cumulative.begin());
  }
}

Noise::Tables::Tables() : normals(make_normals()) {
  constexpr int kMeans = kPerElectron * static_cast<int>(kExactPoisson);
  for (int k = 0; k < kMeans; ++k) poisson.emplace_back(static_cast<double>(k) / kPerElectron);
}

const Noise::Tables& Noise::tables() {
  static const Tables tables;
  return tables;
}

Noise::Noise(std::uint64_t seed, std::uint64_t stream)
    : state_(split_mix(split_mix(seed) + stream)), tables_(tables()) {}

}  // namespace ovws
