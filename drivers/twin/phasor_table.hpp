/// exp(2 pi i turns) from a table, for whole pictures.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace ovws::twin {

/// Within 1/32768 of a turn. Immutable.
class PhasorTable {
 public:
  PhasorTable() {
    for (int k = 0; k < kSize; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kSize;
      table_[std::size_t(k)] = {float(std::cos(angle)), float(std::sin(angle))};
    }
  }

  /// Requires |turns| < 1e5.
  std::complex<float> operator()(float turns) const {
    // By hand: std::floor is a call without SSE 4.1.
    const float place = turns * kSize + 0.5F;
    const int whole = int(place);
    return table_[std::size_t((whole - (place < float(whole) ? 1 : 0)) & (kSize - 1))];
  }

 private:
  static constexpr int kSize = 16384;
  std::array<std::complex<float>, kSize> table_;
};

/// By hand: std::complex's product checks for infinities, which costs ten times as much.
inline std::complex<float> product(std::complex<float> a, std::complex<float> b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

}  // namespace ovws::twin
