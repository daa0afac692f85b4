/// Fits templates of every spot to a simulated exposure, as the daemon's `fit` does.
#pragma once

#include <vector>

#include "core/spots/spot_renderer.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Makes a SpotRenderer for the study's image size and the modes `modes_j`. Not thread-safe.
SpotRenderer renderer_of(const Geometry& geometry, int charge, const std::vector<int>& modes_j,
                         const SpotRenderer::Options& options = {});

/// The noise of an exposure's pixels, DN.
PixelNoise noise_of(const Exposure& exposure, double read_noise_e);

/// Fits the modes in `renderings` damped steps from `start`. Returns coefficients in waves, in the
/// order of the renderer's modes. All are NaN if the spots do not determine the modes, or if
/// `start` is NaN.
std::vector<double> fitted_waves(SpotRenderer& renderer, const Exposure& exposure,
                                 double read_noise_e, std::vector<double> start, int renderings);

}  // namespace ovws::study
