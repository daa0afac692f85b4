/// Weighted sum of a square of complex numbers, for interpolation (SIMD with run-time dispatch).
#pragma once

#include <complex>
#include <cstddef>

namespace ovws::twin {

constexpr int kTapsAcross = 12;

/// Sum over rows r and columns c of along_y[r] along_x[c] first[r stride + c], r and c from 0 to
/// kTapsAcross - 1. Agrees between CPUs within rounding.
std::complex<float> tap_sum(const std::complex<float>* first, std::ptrdiff_t stride,
                            const float* along_x, const float* along_y);

}  // namespace ovws::twin
