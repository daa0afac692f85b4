#include "core/optics/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace ovws {
namespace {

constexpr int kQuantiles = 65536;

/// Spreads each bit of a counter over all bits of the result (the finaliser of SplitMix64, Steele,
/// Lea and Flood 2014).
std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

/// The normal quantiles at (k + 1/2) / kQuantiles, scaled to a variance of exactly 1.
std::vector<float> make_normals() {
  std::vector<double> upper;
  double sum_of_squares = 0.0;
  double z = 0.0;
  for (int k = 0; k < kQuantiles / 2; ++k) {
    const double above_mean = (k + 0.5) / kQuantiles;
    // Newton's method from the quantile before: it converges from below, as the density falls.
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

constexpr std::uint32_t kOne = 1U << 31;  ///< probability 1, against 31 random bits

/// Cumulative Poisson probabilities of one mean, and for each top byte of a random number
/// the count at which to start looking: the search then takes about one step.
struct PoissonTable {
  static constexpr int kCounts = 96;
  std::array<std::uint32_t, kCounts> cumulative{};
  std::array<std::uint8_t, 256> start{};

  /// The smallest count whose cumulative probability exceeds `random`.
  int draw(std::uint32_t random) const {
    int count = start[random >> 23];
    while (random >= cumulative[count]) ++count;
    return count;
  }
};

PoissonTable make_poisson_table(double mean) {
  PoissonTable table;
  double probability = std::exp(-mean);
  double sum = 0.0;
  for (int count = 0; count < PoissonTable::kCounts; ++count) {
    sum += probability;
    table.cumulative[count] = static_cast<std::uint32_t>(std::lround(std::min(sum, 1.0) * kOne));
    probability *= mean / (count + 1.0);
  }
  table.cumulative.back() = kOne;
  for (std::uint32_t byte = 0; byte < table.start.size(); ++byte) {
    const auto found =
        std::upper_bound(table.cumulative.begin(), table.cumulative.end(), byte << 23);
    table.start[byte] = static_cast<std::uint8_t>(found - table.cumulative.begin());
  }
  return table;
}

/// A small mean, by inversion. exp(-mean) >= 1 - mean saves most draws the exponential.
int draw_small(float mean, std::uint32_t random) {
  float left = static_cast<float>(random) / static_cast<float>(kOne);
  if (left < 1.0F - mean) return 0;
  int count = 0;
  for (float probability = std::exp(-mean); left >= probability && count < 16; ++count) {
    left -= probability;
    probability *= mean / static_cast<float>(count + 1);
  }
  return count;
}

}  // namespace

struct Noise::Tables {
  std::vector<float> normals = make_normals();
  static constexpr int kPerElectron = 8;
  static constexpr int kMeans = kPerElectron * static_cast<int>(kExactPoisson);
  std::array<PoissonTable, kMeans> poisson;  ///< of the means k / kPerElectron

  Tables() {
    for (std::size_t k = 0; k < poisson.size(); ++k) {
      poisson[k] = make_poisson_table(static_cast<double>(k) / kPerElectron);
    }
  }
};

const Noise::Tables& Noise::tables() {
  static const Tables tables;
  return tables;
}

Noise::Noise(std::uint64_t seed, std::uint64_t stream)
    : state_(mix(mix(seed) + stream)), tables_(tables()) {}

std::uint64_t Noise::bits() {
  state_ += 0x9e3779b97f4a7c15U;
  return mix(state_);
}

float Noise::normal() {
  return tables_.normals[bits() >> 48];
}

float Noise::poisson(float mean) {
  if (!(mean > 0.0F)) return 0.0F;
  if (mean >= kExactPoisson) return mean + std::sqrt(mean) * normal();
  // The sum of Poisson numbers is one of the summed mean: a table for the most of it, and the rest.
  const int k = static_cast<int>(mean * Tables::kPerElectron);
  const std::uint64_t random = bits();
  const int most = tables_.poisson[k].draw(static_cast<std::uint32_t>(random >> 33));
  const float rest_mean = mean - static_cast<float>(k) / static_cast<float>(Tables::kPerElectron);
  return static_cast<float>(most + draw_small(rest_mean, random & (kOne - 1)));
}

}  // namespace ovws
