/// The Cramer-Rao bound of a wavefront's modes from all pixels of an image.
#pragma once

#include <span>

#include "core/optics/zernike.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Trace of the inverse Fisher matrix of the modes (amplitude and background unknown too) at these
/// modes, rad^2: no method leaves less residual variance without being biased. NaN if the image
/// does not tell them.
double wavefront_bound_rad2(const Geometry& geometry, int charge, std::span<const Mode> modes,
                            const Image<float>& light_e, double read_noise_e);

}  // namespace ovws::study
