/// Fast reproducible pseudo-random numbers (normal, Poisson) for simulated pixels.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace ovws {

/// A stream of independent variates (SplitMix64). For one thread at a time; cheap to construct.
class Noise {
 public:
  /// Streams with different seeds, or with different numbers and the same seed, are independent.
  Noise(std::uint64_t seed, std::uint64_t stream);

  /// Standard normal variate: one of 65536 equally likely quantiles, so never beyond 4.4.
  float normal();

  /// Poisson variate for means below kExactPoisson; above, a normal one with the same mean and
  /// variance. A mean that is negative or NaN counts as 0.
  float poisson(float mean);

  static constexpr float kExactPoisson = 30.0F;

 private:
  static constexpr std::uint32_t kOne = 1U << 31;  ///< probability 1, against 31 random bits

  /// Inverse-transform sampling of a Poisson distribution: its cumulative probabilities, and a
  /// guide table with the first count for each top byte of a random number. A search takes about
  /// one step.
  struct PoissonTable {
    static constexpr int kCounts = 96;
    std::array<std::uint32_t, kCounts> cumulative{};
    std::array<std::uint8_t, 256> start{};

    explicit PoissonTable(double mean);
    /// The smallest count whose cumulative probability exceeds `random`.
    int draw(std::uint32_t random) const {
      int count = start[random >> 23];
      while (random >= cumulative[std::size_t(count)]) ++count;
      return count;
    }
  };
  struct Tables {
    static constexpr int kPerElectron = 8;
    std::vector<float> normals;
    std::vector<PoissonTable> poisson;  ///< of the means k / kPerElectron

    Tables();
  };
  static const Tables& tables();
  static int draw_small(float mean, std::uint32_t random);
  std::uint64_t bits();

  std::uint64_t state_;
  const Tables& tables_;
};

// Inline: a simulated frame draws a million numbers.

/// Bit mixer: the finaliser of SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom
/// number generators", 2014).
inline std::uint64_t split_mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

inline std::uint64_t Noise::bits() {
  state_ += 0x9e3779b97f4a7c15U;
  return split_mix(state_);
}

inline float Noise::normal() {
  return tables_.normals[bits() >> 48];
}

inline float Noise::poisson(float mean) {
  if (!(mean > 0.0F)) return 0.0F;
  if (mean >= kExactPoisson) return mean + std::sqrt(mean) * normal();
  // The sum of Poisson numbers is one of the summed mean: a table for the most of it, and the rest.
  const int k = static_cast<int>(mean * Tables::kPerElectron);
  const std::uint64_t random = bits();
  const int most = tables_.poisson[std::size_t(k)].draw(static_cast<std::uint32_t>(random >> 33));
  const float rest_mean = mean - static_cast<float>(k) / static_cast<float>(Tables::kPerElectron);
  return static_cast<float>(most + draw_small(rest_mean, random & (kOne - 1)));
}

/// Poisson number of a small mean, by inverse-transform sampling. Most draws need no exponential,
/// because exp(-mean) >= 1 - mean.
inline int Noise::draw_small(float mean, std::uint32_t random) {
  float left = static_cast<float>(random) / static_cast<float>(kOne);
  if (left < 1.0F - mean) return 0;
  int count = 0;
  for (float probability = std::exp(-mean); left >= probability && count < 16; ++count) {
    left -= probability;
    probability *= mean / static_cast<float>(count + 1);
  }
  return count;
}

}  // namespace ovws
