/// What a refinement found, and whether it can be believed: of image files and of live frames.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/control/refine_settings.hpp"
#include "core/wavefront/refine.hpp"

namespace ovws {

/// How the camera made a picture of electrons: the mean of `frames` frames of this format and gain,
/// amplitude gain 10^(gain_db/20). Rounding to whole DN is part of its noise. Requires
/// electrons_per_dn.
RefineCamera refine_camera(const RefineSettings& stated, PixelFormat format, double gain_db,
                           int frames);

/// Noise of rounding to whole DN, electrons RMS.
inline double rounding_e(double electrons_per_dn) {
  return electrons_per_dn / std::sqrt(12.0);
}

struct RefinedModes {
  std::vector<double> waves;        ///< minus the reference's, in the order of the modes given
  std::vector<double> sigma_waves;  ///< standard errors, the reference's included
  double chi2_per_pixel = 0.0;      ///< about 1 if the model explains the image
  double peak_e = 0.0;              ///< of the model's brightest pixel above the background
  double background_e = 0.0;        ///< a pixel, above the black level
  int iterations = 0;
  std::vector<double> amplitudes{};  ///< of each subaperture, see Refinement; empty: not fitted

  /// Why it cannot be believed, for a person: no light, too little to tell the modes, or a model
  /// that does not explain it. None: it can. `frames`: how many the picture is the mean of, of
  /// which each may misfit as much as a single one.
  std::optional<std::string> doubt(const RefineCamera& camera, int frames = 1) const;
};

/// The same without a reference.
RefinedModes refined_modes(const Refinement& found);
/// `found` counted from `reference`, whose modes are the same.
RefinedModes minus(RefinedModes found, const RefinedModes& reference);

}  // namespace ovws
