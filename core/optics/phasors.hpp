/// Phases of 16 bits, and their phasors from a table, for whole images.
#pragma once

#include <bit>
#include <complex>
#include <cstdint>
#include <numbers>
#include <vector>

namespace ovws {

constexpr double kPhasesPerWave = 65536.0;
/// Adding 1.5 * 2^52 to a double leaves the rounded integer in its low bits, without a branch and
/// without an undefined conversion.
constexpr double kRounder = 0x1.8p52;

/// Converts waves to 16-bit phase (65536 = 2 pi): rounds to the nearest 1/65536 wave (ties to even)
/// and drops whole waves. Never undefined behaviour, but meaningless for very large values.
inline std::uint16_t phase16(double waves) {
  return std::uint16_t(std::bit_cast<std::uint64_t>(waves * kPhasesPerWave + kRounder));
}

/// exp(2 pi i k / 65536), for each 16-bit phase.
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
