/// Fast reproducible pseudo-random numbers (normal, Poisson) for simulated pixels.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ovws {

/// A stream of independent variates (SplitMix64). For one thread at a time; cheap to construct.
class Noise {
 public:
  /// `stream`: the stream's number. Streams that differ in seed or number are independent.
  Noise(std::uint64_t seed, std::uint64_t stream);

  /// Standard normal variate: the scaled sum of two out of 4096 equally likely quantiles, never
  /// beyond 5.2.
  float normal();

  /// Poisson variate for means below kExactPoisson; above, a normal one with the same mean and
  /// variance. A mean that is negative or NaN counts as 0.
  float poisson(float mean);

  static constexpr float kExactPoisson = 30.0F;

 private:
  /// A Poisson distribution by the alias method (Walker 1977): a random column of equally many
  /// counts holds its own count with probability `share`, and otherwise `alias`.
  struct Column {
    static constexpr unsigned kCountBits = 7;
    static constexpr unsigned kShareBits = 32 - kCountBits;
    std::uint32_t share : kShareBits;
    std::uint32_t alias : kCountBits;
  };
  /// Small enough for the processor's caches, because each pixel reads a random place.
  struct Tables {
    static constexpr int kPerElectron = 8;
    static constexpr unsigned kQuantileBits = 12;
    std::vector<float> half_normals;  ///< quantiles of variance 1/2
    std::vector<Column> poisson;      ///< 2^kCountBits for each of the means k / kPerElectron

    Tables();
  };
  static const Tables& tables();
  static int poisson_below_one(float mean, float random);
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

inline Noise::Noise(std::uint64_t seed, std::uint64_t stream)
    : state_(split_mix(split_mix(seed) + stream)), tables_(tables()) {}

inline std::uint64_t Noise::bits() {
  state_ += 0x9e3779b97f4a7c15U;
  return split_mix(state_);
}

inline float Noise::normal() {
  constexpr unsigned kBits = Tables::kQuantileBits;
  const std::uint64_t random = bits();
  return tables_.half_normals[random >> (64 - kBits)] +
         tables_.half_normals[(random >> (64 - 2 * kBits)) & ((1U << kBits) - 1)];
}

inline float Noise::poisson(float mean) {
  if (!(mean > 0.0F)) return 0.0F;
  if (mean >= kExactPoisson) return mean + std::sqrt(mean) * normal();
  // The sum of Poisson numbers is one of the summed mean: a table for the most of it, and the rest.
  const int k = static_cast<int>(mean * Tables::kPerElectron);
  const std::uint64_t random = bits();
  const auto count = static_cast<std::uint32_t>(random >> (64 - Column::kCountBits));
  const Column column = tables_.poisson[(std::size_t(k) << Column::kCountBits) + count];
  const auto share = static_cast<std::uint32_t>(random >> 32) & ((1U << Column::kShareBits) - 1);
  const std::uint32_t most = share < column.share ? count : column.alias;
  const float rest_mean = mean - static_cast<float>(k) / static_cast<float>(Tables::kPerElectron);
  const float rest_random = static_cast<float>(static_cast<std::uint32_t>(random) >> 8) * 0x1p-24F;
  return static_cast<float>(int(most) + poisson_below_one(rest_mean, rest_random));
}

/// Poisson number of a small mean, by inverse-transform sampling with a random number in [0, 1).
/// Most draws need no exponential, because exp(-mean) >= 1 - mean.
inline int Noise::poisson_below_one(float mean, float random) {
  if (random < 1.0F - mean) return 0;
  int count = 0;
  for (float probability = std::exp(-mean); random >= probability && count < 16; ++count) {
    random -= probability;
    probability *= mean / static_cast<float>(count + 1);
  }
  return count;
}

}  // namespace ovws
