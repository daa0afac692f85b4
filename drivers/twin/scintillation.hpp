/// Amplitude screen: scintillation of the light on the sensor, which does not change with time.
#pragma once

#include <Eigen/Core>

#include "drivers/twin/deformable_mirror.hpp"

namespace ovws::twin {

/// Log-normal intensity of mean 1. Its logarithm is a Gaussian random field with the correlation
/// exp(-(d / scale)^2) at the distance d.
struct ScintillationConfig {
  double variance = 0.3;      ///< of the intensity
  double scale_pupils = 0.1;  ///< correlation length, pupil diameters
  int seed = 1;

  friend bool operator==(const ScintillationConfig&, const ScintillationConfig&) = default;
};

/// Amplitude at a grid of positions, indices (x, y). The same positions always get the same value.
Eigen::MatrixXf amplitude_screen(const ScintillationConfig& scintillation, const PupilLine& x,
                                 const PupilLine& y);

}  // namespace ovws::twin
