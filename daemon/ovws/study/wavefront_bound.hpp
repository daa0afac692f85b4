/// Cramer-Rao bound of the modes from all pixels of an image.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/spots/spot_renderer.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Makes a renderer whose windows do not overlap and hold nearly all of each spot's intensity.
SpotRenderer bound_renderer_of(const Geometry& geometry, int charge,
                               const std::vector<int>& modes_j);

/// Cramer-Rao bound: inverse Fisher matrix of the renderer's modes at the wavefront `modes`,
/// waves^2. One amplitude and one background, common to all spots, are further unknowns. `light_e`:
/// the noise-free image of this wavefront, electrons. No unbiased estimate of the modes has smaller
/// errors. NaN if the image does not determine the modes.
Eigen::MatrixXd pixel_covariance(SpotRenderer& renderer, std::span<const Mode> modes,
                                 const Image<float>& light_e, double read_noise_e);

/// Cramer-Rao bound of the residual variance, rad^2: trace of pixel_covariance for all modes that
/// spot positions determine.
double wavefront_bound_rad2(const Geometry& geometry, int charge, std::span<const Mode> modes,
                            const Image<float>& light_e, double read_noise_e);

}  // namespace ovws::study
