/// Series of numbers for tests of spectra.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace ovws::test {

/// 0, step_s, 2 step_s, …
inline std::vector<double> times(int count, double step_s) {
  std::vector<double> out;
  for (int k = 0; k < count; ++k) out.push_back(k * step_s);
  return out;
}

/// Independent normal numbers with standard deviation 1.
inline std::vector<double> noise(int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> out;
  for (int k = 0; k < count; ++k) out.push_back(normal(random));
  return out;
}

}  // namespace ovws::test
