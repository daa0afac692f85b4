/// Simulated exposures of one spot with a camera's noise, in electrons; fast enough for thousands.
#pragma once

#include <cstdint>

#include "core/base/image.hpp"
#include "core/tracking/spot_shape.hpp"

namespace ovws::test {

constexpr int kNoisySide = 72;        ///< pixels
constexpr double kNoisyPeak = 500.0;  ///< electrons

/// Mean electrons of a spot of kNoisyPeak at `at`.
Image<float> mean_electrons(const ModelShape& shape, Vec2 at);

/// Read noise that makes the brightest pixel's signal `snr` times its noise.
double read_noise_of(double snr);

/// The Cramer-Rao bound for the position of such a spot at `at`, RMS per axis, pixels: level and
/// background unknown, Gaussian noise whose mean alone counts.
double bound_px(const ModelShape& shape, Vec2 at, double read_noise_e);

/// Adds shot noise, read noise and a black level so high that no noise is clipped at 0, and rounds
/// to 1 DN per electron, 12 bit. Reproducible for a seed.
Image<std::uint16_t> expose12(const Image<float>& electrons, double read_noise_e,
                              std::uint64_t seed);

}  // namespace ovws::test
