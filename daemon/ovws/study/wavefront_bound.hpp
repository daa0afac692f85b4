/// Cramer-Rao bound of the modes from all pixels of an image.
#pragma once

#include <span>

#include "core/optics/zernike.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Trace of the inverse Fisher matrix of the modes at this wavefront, rad^2, with amplitude and
/// background as further unknowns. No unbiased method has less residual variance. NaN if the image
/// does not determine the modes.
double wavefront_bound_rad2(const Geometry& geometry, int charge, std::span<const Mode> modes,
                            const Image<float>& light_e, double read_noise_e);

}  // namespace ovws::study
