/// Fast reproducible pseudo-random numbers (normal, Poisson) for simulated pixels.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ovws {

/// What a detector makes of a pixel's mean number of electrons.
struct PixelChain {
  bool shot_noise = true;
  float read_noise_e = 0.0F, full_well_e = 0.0F;
  float dn_per_e = 1.0F, black_dn = 0.0F, top_dn = 0.0F;
};

/// Stream of independent random variates (SplitMix64). Cheap to construct. Use from one thread.
class Noise {
 public:
  /// `stream`: number of the stream. Streams with another seed or number are independent.
  Noise(std::uint64_t seed, std::uint64_t stream);

  /// Standard normal variate: sum of two random entries of a table of 4096 scaled quantiles. Its
  /// absolute value never exceeds 5.2.
  float normal();

  /// Poisson variate for a mean below kExactPoisson. From kExactPoisson on, a normal variate with
  /// the same mean and variance. A negative or NaN mean counts as 0.
  float poisson(float mean);

  static constexpr float kExactPoisson = 30.0F;
  static constexpr unsigned kQuantileBits = 12;  ///< of the entries of the table of quantiles

  /// Pixel values of many pixels at once, from their mean numbers of electrons (NaN counts as 0):
  /// shot noise as `poisson`, full well, read noise as `normal`, gain, black level, clipping,
  /// rounding. The values of a pixel depend on the stream, its number and its mean; the last digit
  /// may differ between CPUs.
  static void expose(std::uint64_t seed, std::uint64_t stream, const PixelChain& chain,
                     std::span<const float> mean_e, std::uint16_t* dn);

 private:
  /// Column of the alias method (Walker 1977) for a Poisson distribution. Column k is drawn with
  /// equal probability; it returns count k with probability `share`, otherwise count `alias`.
  struct Column {
    static constexpr unsigned kCountBits = 7;
    static constexpr unsigned kShareBits = 32 - kCountBits;
    std::int32_t bits;  ///< the share in the lower ones
    std::uint32_t share() const { return std::uint32_t(bits) & ((1U << kShareBits) - 1); }
    std::uint32_t alias() const { return std::uint32_t(bits) >> kShareBits; }
  };
  /// Look-up tables, small enough for the CPU caches: each pixel reads a random entry.
  struct Tables {
    static constexpr int kPerElectron = 8;
    std::vector<float> half_normals;  ///< normal quantiles, scaled to variance 1/2
    std::vector<std::int32_t>
        poisson;  ///< bits of Column: 2^kCountBits columns per mean k / kPerElectron

    Tables();
  };
  static const Tables& tables();
  static int poisson_below_one(float mean, float random);
  std::uint64_t bits();

  std::uint64_t state_;
  const Tables& tables_;
};

// Inline functions, for speed: a simulated frame draws a million random numbers.

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
  constexpr unsigned kBits = kQuantileBits;
  const std::uint64_t random = bits();
  return tables_.half_normals[random >> (64 - kBits)] +
         tables_.half_normals[(random >> (64 - 2 * kBits)) & ((1U << kBits) - 1)];
}

inline float Noise::poisson(float mean) {
  if (!(mean > 0.0F)) return 0.0F;
  if (mean >= kExactPoisson) return mean + std::sqrt(mean) * normal();
  // The sum of two Poisson variates is Poisson, too. Draw one for the mean rounded down to 1/8 from
  // the table, and one for the small remaining mean.
  const int k = static_cast<int>(mean * Tables::kPerElectron);
  const std::uint64_t random = bits();
  const auto count = static_cast<std::uint32_t>(random >> (64 - Column::kCountBits));
  const Column column{tables_.poisson[(std::size_t(k) << Column::kCountBits) + count]};
  const auto share = static_cast<std::uint32_t>(random >> 32) & ((1U << Column::kShareBits) - 1);
  const std::uint32_t most = share < column.share() ? count : column.alias();
  const float rest_mean = mean - static_cast<float>(k) / static_cast<float>(Tables::kPerElectron);
  const float rest_random = static_cast<float>(static_cast<std::uint32_t>(random) >> 8) * 0x1p-24F;
  return static_cast<float>(int(most) + poisson_below_one(rest_mean, rest_random));
}

/// Poisson variate for a small mean, by inverse-transform sampling of a random number in [0, 1).
/// Most draws return 0 without computing exp(-mean), because exp(-mean) >= 1 - mean.
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
