/// Exposures of one spot with a camera's noise, in electrons, quick enough for thousands.
#pragma once

#include <cstdint>

#include "core/base/image.hpp"
#include "core/tracking/localisation_bound.hpp"
#include "core/tracking/spot_shape.hpp"

namespace ovws::test {

constexpr int kNoisySide = 72;        ///< pixels
constexpr double kNoisyPeak = 500.0;  ///< electrons

/// Mean electrons of a spot of kNoisyPeak at `at`.
Image<float> mean_electrons(const SpotShape& shape, Vec2 at);

/// Read noise that makes the brightest pixel's signal `snr` times its noise.
double read_noise_of(double snr);

/// Shot noise, read noise, a black level that no noise reaches below, and rounding to 1 DN per
/// electron, 12 bit; the same for the same seed.
Image<std::uint16_t> expose12(const Image<float>& electrons, double read_noise_e,
                              std::uint64_t seed);

}  // namespace ovws::test
