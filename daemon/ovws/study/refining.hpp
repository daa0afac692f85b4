/// Fits the modes to all pixels of a simulated exposure.
#pragma once

#include <vector>

#include "core/wavefront/refine.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// A Refiner for the study's image size and these modes; for one thread at a time.
Refiner refiner_of(const Geometry& geometry, int charge, const std::vector<int>& modes_j);

/// Coefficients in waves, in the order of the Refiner's modes. If `start` is NaN, the fit starts
/// from a flat wavefront. All NaN if the fit finds no minimum.
std::vector<double> refined_waves(Refiner& refiner, const Exposure& exposure, double read_noise_e,
                                  std::vector<double> start);

}  // namespace ovws::study
