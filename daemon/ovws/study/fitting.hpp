/// Fits templates of every spot to a simulated exposure, as the daemon's `fit` does.
#pragma once

#include <vector>

#include "core/spots/spot_renderer.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// A SpotRenderer for the study's image size and these modes; for one thread at a time.
SpotRenderer renderer_of(const Geometry& geometry, int charge, const std::vector<int>& modes_j,
                         const SpotRenderer::Options& options = {});

/// The noise of an exposure's pixels, DN.
PixelNoise noise_of(const Exposure& exposure, double read_noise_e);

/// Coefficients in waves, in the order of the renderer's modes, after `renderings` from `start`;
/// all NaN if the spots do not determine the modes, or if `start` is NaN.
std::vector<double> fitted_waves(SpotRenderer& renderer, const Exposure& exposure,
                                 double read_noise_e, std::vector<double> start, int renderings);

}  // namespace ovws::study
