/// Operating point of templates: the wavefront at which they are exact, and their other inputs.
#pragma once

#include <vector>

#include "core/base/vec2.hpp"
#include "core/optics/sensor_field.hpp"
#include "core/optics/zernike.hpp"
#include "core/spots/pixel_noise.hpp"

namespace ovws {

/// Deviations of a real bench from the model, for each subaperture; empty: none. Uneven or
/// vignetted illumination, and aberrations beyond the modes, change the field over a subaperture.
struct SpotDeviations {
  std::vector<Vec2> offsets_px;                 ///< spot displacement that no mode explains
  std::vector<SensorField::LocalField> fields;  ///< 1 + this polynomial multiplies the field
};

/// Operating point: the wavefront for which templates are made, and all their other inputs except
/// sensor, optics and calibration. Equal operating points give equal templates.
struct OperatingPoint {
  std::vector<double> waves;            ///< measured modes of the wavefront, RMS-normalised
  std::vector<double> reference_waves;  ///< wavefront of the reference, zero of the coefficients
  std::vector<Mode> fixed;              ///< modes on the SLM that are not measured
  SpotDeviations deviations;
  /// Wavefront of the calibration that corrects the rendering (SpotCorrection); empty: none does.
  std::vector<double> corrected_at;
  PixelNoise noise;
  int lit = 0;  ///< number of spots in the reference
  std::vector<double>
      levels_dn;              ///< of each spot: DN of a camera pixel of intensity 1; 0: not used
  double ceiling_dn = 0.0;    ///< camera pixels this far above the background are near saturation
  int estimates = 8;          ///< number of estimates per spot
  bool measured = false;      ///< true: templates from a calibration; false: rendered
  double higher_waves = 0.0;  ///< RMS of the unmeasured higher modes that the errors include
  double max_excess = 0.1;    ///< largest weighted residual of a spot, fraction
};

}  // namespace ovws
