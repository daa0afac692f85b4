/// SIMD kernels for a hologram's rows: phase of the modes, and look-up of the grey levels.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace ovws {

/// Number of SIMD lanes: lane L of a row segment computes its pixels L, L + 16, L + 32, ...
constexpr int kPhaseLanes = 16;
/// Maximum degree of a row's polynomial.
constexpr int kMaxPhaseDegree = 20;
/// Steps that `phases` may write beyond the requested ones.
constexpr int kSpareSteps = 1;

/// One SIMD build of the kernels. All builds give bit-identical results.
struct HologramRowKernels {
  std::string_view name;
  /// Evaluates a polynomial by forward differences: the 16-bit phase (65536 = 2 pi) of
  /// steps * kPhaseLanes pixels, rounded to nearest, ties upwards. In each lane the k-th difference
  /// per step is a polynomial in `y` of degree `degree` - k, with a value below 2^51 waves in
  /// magnitude. `terms` holds the coefficients in waves, by k, then rising power of y, then lane.
  /// The differences are summed as 64-bit integers, where 2^64 is one wave.
  void (*phases)(const double* terms, int degree, double y, int steps, std::uint16_t* phase);
  /// grey = lut[top 8 bits of (base + added)], modulo 65536, for `count` pixels. `lut` has 256
  /// levels.
  void (*greys)(const std::uint16_t* base, const std::uint16_t* added, const std::uint8_t* lut,
                int count, std::uint8_t* grey);
};

/// The builds that this CPU can run, the fastest last.
std::span<const HologramRowKernels> hologram_row_kernels();

}  // namespace ovws
