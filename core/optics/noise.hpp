/// Random numbers for simulated pixels: quick, and the same again for the same seed.
#pragma once

#include <cstdint>

namespace ovws {

/// A stream of independent draws (SplitMix64). For one thread at a time; cheap to make.
class Noise {
 public:
  /// Streams of different seeds, or of different numbers with one seed, are independent.
  Noise(std::uint64_t seed, std::uint64_t stream);

  /// Mean 0, variance 1: one of 65536 equally likely quantiles of the normal distribution, so never
  /// beyond 4.4.
  float normal();

  /// Poisson distributed up to a mean of kExactPoisson, beyond it normal with the same mean and
  /// variance. A mean below 0 or NaN counts as 0.
  float poisson(float mean);

  static constexpr float kExactPoisson = 30.0F;

 private:
  struct Tables;
  static const Tables& tables();
  std::uint64_t bits();

  std::uint64_t state_;
  const Tables& tables_;
};

}  // namespace ovws
