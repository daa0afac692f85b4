/// Modes from all pixels of a study's exposure.
#pragma once

#include <vector>

#include "core/wavefront/refine.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Of the study's image and these modes, for one thread at a time.
Refiner refiner_of(const Geometry& geometry, int charge, const std::vector<int>& modes_j);

/// In the order of the Refiner's modes; from a flat wavefront if `start` holds NaN. NaN: no
/// minimum.
std::vector<double> refined_waves(Refiner& refiner, const Exposure& exposure, double read_noise_e,
                                  std::vector<double> start);

}  // namespace ovws::study
