/// 16-bit phases, and a table of their phasors exp(i phase), for fast processing of whole images.
#pragma once

#include <bit>
#include <complex>
#include <cstdint>
#include <numbers>
#include <vector>

namespace ovws {

constexpr double kPhasesPerWave = 65536.0;
/// Rounding constant 1.5 * 2^52: adding it to a double leaves the rounded integer in the low bits
/// of the sum. This needs no branch and no conversion that could be undefined.
constexpr double kRounder = 0x1.8p52;

/// Converts waves to 16-bit phase (65536 = 2 pi): rounds to the nearest 1/65536 wave (ties to even)
/// and drops whole waves. Very large values give a meaningless phase, but no undefined behaviour.
inline std::uint16_t phase16(double waves) {
  return std::uint16_t(std::bit_cast<std::uint64_t>(waves * kPhasesPerWave + kRounder));
}

/// Phasor table: element k is exp(2 pi i k / 65536), for each 16-bit phase k.
inline const std::vector<std::complex<float>>& unit_phasors() {
  static const auto table = [] {
    std::vector<std::complex<float>> made;
    for (int k = 0; k < 65536; ++k) {
      const auto exact = std::polar(1.0, 2.0 * std::numbers::pi * double(k) / kPhasesPerWave);
      made.push_back(std::complex<float>(exact));
    }
    return made;
  }();
  return table;
}

}  // namespace ovws
