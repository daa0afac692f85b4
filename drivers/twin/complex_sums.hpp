/// Product of complex matrices whose real and imaginary parts are apart (SIMD with run-time
/// dispatch).
#pragma once

#include <complex>
#include <cstddef>

namespace ovws::twin {

/// Rows of complex numbers: real parts and imaginary parts, `stride` numbers from row to row.
struct SplitRows {
  float* re;
  float* im;
  std::ptrdiff_t stride;
};

constexpr int kSplitLanes = 16;  ///< the width of split rows is a multiple of this

/// Adds the product of `a` (rows x depth, row by row) and `b` (depth x width) to `sum` (rows x
/// width).
void add_product(const std::complex<float>* a, int rows, int depth, const SplitRows& b, int width,
                 const SplitRows& sum);

}  // namespace ovws::twin
