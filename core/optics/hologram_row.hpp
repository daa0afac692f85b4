/// The two loops over a hologram's row: the modes' phase, and the grey levels it becomes.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace ovws {

/// Pixels that advance together: lane L of a stretch has its pixels L, L + 16, L + 32, ...
constexpr int kPhaseLanes = 16;
/// The highest degree of a row's polynomial.
constexpr int kMostPhaseDegree = 20;
/// Steps beyond those asked that `phases` may write.
constexpr int kSpareSteps = 1;

/// One build of the loops. The builds agree bit for bit.
struct HologramRowKernels {
  std::string_view name;
  /// Phase, 2 pi = 65536, of steps * kPhaseLanes pixels: the polynomial whose k-th forward
  /// difference in steps is, for each lane, a polynomial in `y` of degree `degree` - k. `terms`
  /// holds them by k, rising power of y, and lane; in waves, less than 2^51 each. Rounded to the
  /// nearest 1/65536 wave, a tie upwards. 64-bit integers from the differences on, 2^64 one wave.
  void (*phases)(const double* terms, int degree, double y, int steps, std::uint16_t* phase);
  /// grey = lut[top 8 bits of (base + added)], modulo 65536, for `count` pixels. `lut` has 256
  /// levels.
  void (*greys)(const std::uint16_t* base, const std::uint16_t* added, const std::uint8_t* lut,
                int count, std::uint8_t* grey);
};

/// Those that this CPU can run, the fastest last.
std::span<const HologramRowKernels> hologram_row_kernels();

}  // namespace ovws
