/// Product of light with the phasors of a wavefront (SIMD with run-time dispatch).
#pragma once

#include <complex>

namespace ovws::twin {

/// Multiplies values[k] by exp(2 pi i waves[k]), within 1e-6, for k = 0 .. count - 1.
void multiply_by_phasors(const float* waves, int count, std::complex<float>* values);

}  // namespace ovws::twin
