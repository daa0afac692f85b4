/// The operating point: the wavefront that templates are exact for, and all that determines them
/// besides sensor and optics, or besides the calibration that measured them.
#pragma once

#include <vector>

#include "core/base/vec2.hpp"
#include "core/optics/sensor_field.hpp"
#include "core/optics/zernike.hpp"
#include "core/spots/pixel_noise.hpp"

namespace ovws {

/// What a real bench does differently from the model, for each subaperture; empty: nothing. Uneven
/// or cut light, and what aberrations the modes do not hold, change the field over a subaperture.
struct SpotDeviations {
  std::vector<Vec2> offsets_px;                 ///< of its spot, which no mode makes
  std::vector<SensorField::LocalField> fields;  ///< added to 1, times its field
};

/// The wavefront that templates are made for, and all else that they depend on besides the sensor
/// and its optics, or its calibration. From an equal point the same templates can be made again.
struct OperatingPoint {
  std::vector<double> waves;            ///< of the measured modes, RMS-normalised
  std::vector<double> reference_waves;  ///< of the reference, from which coefficients count
  std::vector<Mode> fixed;              ///< modes on the SLM that are not measured
  SpotDeviations deviations;
  PixelNoise noise;
  int lit = 0;  ///< spots that the reference has
  std::vector<double>
      levels_dn;              ///< of each spot: DN of a camera pixel of intensity 1; 0: not used
  double ceiling_dn = 0.0;    ///< of a camera pixel above the background: saturation is near
  int estimates = 8;          ///< of each spot
  bool measured = false;      ///< templates are of a calibration; else they are rendered
  double higher_waves = 0.0;  ///< RMS of higher_modes that the errors hold
  double max_excess = 0.1;    ///< fraction of a spot's weighted light that templates may leave
};

}  // namespace ovws
