/// Result of a refinement (maximum-likelihood fit), and whether it is credible. For image files and
/// live frames.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/control/refine_settings.hpp"
#include "core/wavefront/refine.hpp"

namespace ovws {

/// Camera noise model for the mean of `frames` frames of this format and gain (amplitude gain
/// 10^(gain_db/20)). Its read noise includes the rounding to whole DN. Requires electrons_per_dn.
RefineCamera refine_camera(const RefineSettings& stated, PixelFormat format, double gain_db,
                           int frames);

/// Noise of rounding to whole DN, electrons RMS.
inline double rounding_e(double electrons_per_dn) {
  return electrons_per_dn / std::sqrt(12.0);
}

struct RefinedModes {
  std::vector<double> waves;        ///< minus the reference's, in the order of the requested modes
  std::vector<double> sigma_waves;  ///< standard errors, including the reference's
  double chi2_per_pixel = 0.0;      ///< about 1 if the model explains the image
  double peak_e = 0.0;              ///< of the model's brightest pixel above the background
  double background_e = 0.0;        ///< per pixel, above the black level
  int iterations = 0;
  std::vector<double> amplitudes{};  ///< of each subaperture, see Refinement; empty: not fitted

  /// Why the result is not credible, as a message: no light, too few photons for the modes, or a
  /// model that does not explain the image. None: it is credible. `frames`: how many frames the
  /// image is the mean of; the limit on chi2 grows with it.
  std::optional<std::string> doubt(const RefineCamera& camera, int frames = 1) const;
};

/// Converts the result of a fit; no reference is subtracted.
RefinedModes refined_modes(const Refinement& found);
/// Subtracts `reference`, which must have the same modes. Standard errors add in quadrature.
RefinedModes minus(RefinedModes found, const RefinedModes& reference);

}  // namespace ovws
