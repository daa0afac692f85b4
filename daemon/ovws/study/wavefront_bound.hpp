/// Cramer-Rao bound of the modes from all pixels of an image.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/spots/spot_renderer.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Renders spots in windows that hold nearly all of their light, and do not overlap.
SpotRenderer bound_renderer_of(const Geometry& geometry, int charge,
                               const std::vector<int>& modes_j);

/// Inverse Fisher matrix of the renderer's modes at the wavefront `modes`, waves^2, with one
/// amplitude and one background of all spots as further unknowns. `light_e`: its image without
/// noise, electrons. No unbiased estimate of the modes has smaller errors. NaN if the image does
/// not determine them.
Eigen::MatrixXd pixel_covariance(SpotRenderer& renderer, std::span<const Mode> modes,
                                 const Image<float>& light_e, double read_noise_e);

/// Its trace for all modes that positions determine, rad^2.
double wavefront_bound_rad2(const Geometry& geometry, int charge, std::span<const Mode> modes,
                            const Image<float>& light_e, double read_noise_e);

}  // namespace ovws::study
