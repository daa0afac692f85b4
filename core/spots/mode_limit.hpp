/// How many modes the spots of a sensor determine.
#pragma once

#include "core/base/pixel_format.hpp"
#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"

namespace ovws {

/// A sensor on its bench, and how many estimates each spot gives.
struct ModeBench {
  const SensorConfig& sensor;
  const SlmGeometry& slm;
  const OpticsConfig& optics;
  int cols = 0, rows = 0;  ///< size of the camera image
  int estimates = 0;
  LitPixels lit{};        ///< camera pixels that the laser reaches
  double peak_e = 500.0;  ///< electrons in the brightest pixel
  double read_noise_e = 5.0;
};

/// Standard errors of the modes j = 1 to `modes` for a flat wavefront.
struct ModeErrors {
  int modes = 0;
  double rms_waves = 0.0;       ///< root sum square of the standard errors without tilts
  double worst_waves = 0.0;     ///< largest standard error of a mode
  double tilt_waves = 0.0;      ///< standard error of a tilt that is the only mode
  double light_per_peak = 0.0;  ///< electrons in the windows of all spots per one of the peak

  /// Modes are determined if no standard error exceeds twice `tilt_waves`. With more modes the
  /// error grows steeply: 19 vortices of charge 1 determine 47 modes, 19 bright spots 26.
  bool are_determined() const { return worst_waves <= 2.0 * tilt_waves; }
};

/// Computes the errors for `modes` modes; infinite if the estimates do not determine all modes.
/// Renders the spots, some 20 ms on the default bench. Errors: those of SpotRenderer::make.
Result<ModeErrors> mode_errors(const ModeBench& bench, int modes);

/// Finds the largest number of modes that are determined, at most `below` (at least 1), by
/// bisection in one rendering. Errors: those of SpotRenderer::make.
Result<ModeErrors> most_modes(const ModeBench& bench, int below);

}  // namespace ovws
