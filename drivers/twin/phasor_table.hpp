/// Look-up table of exp(2 pi i turns), for whole images.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/base/complex_product.hpp"

namespace ovws::twin {

/// Phasor table with a phase error of at most 1/32768 turn. Immutable.
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
    // Floor written out: std::floor is a function call without SSE 4.1.
    const float position = turns * kSize + 0.5F;
    const int index = int(position);
    return table_[std::size_t((index - (position < float(index) ? 1 : 0)) & (kSize - 1))];
  }

 private:
  static constexpr int kSize = 16384;
  std::array<std::complex<float>, kSize> table_;
};

}  // namespace ovws::twin
