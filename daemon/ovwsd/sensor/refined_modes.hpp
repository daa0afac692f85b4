/// Result of a refinement, a fit of all pixels with a known camera, and whether it is credible. For
/// image files and live frames.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/control/refine_settings.hpp"
#include "core/spots/point_model.hpp"

namespace ovws {

/// The noise of the camera's pixels, DN.
PixelNoise pixel_noise(const RefineCamera& camera);

/// Camera noise model for a frame of this format and gain (amplitude gain 10^(gain_db/20)).
/// Requires electrons_per_dn.
RefineCamera refine_camera(const RefineSetup& stated, PixelFormat format, double gain_db);

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
  std::vector<double> amplitudes{};  ///< of each subaperture's field, RMS 1; 0: no spot

  /// Why the result is not credible, as a message: no light, too few photons for the modes, or a
  /// model that does not explain the image. None: it is credible.
  std::optional<std::string> doubt(const RefineCamera& camera) const;
};

/// Finds the modes from one of `starts` by rendering all spots again and again, until the step is
/// small; some 15 ms for each rendering on the default bench. Errors: those of
/// PointModel::templates.
Result<RefinedModes> refine(PointModel& model, const ImageView& image, const RefineCamera& camera,
                            PointModel::Starts starts, std::span<const Mode> fixed);

/// The same without a reference: the modes against the model, which first learns from the image
/// what the bench does differently over each subaperture; some tenths of a second. Errors: those of
/// PointModel::templates and PointModel::use_reference; Errc::refused, field "image": the wavefront
/// has modes above the measured ones.
Result<RefinedModes> refine_absolute(PointModel& model, const ImageView& image,
                                     const RefineCamera& camera, PointModel::Starts starts,
                                     std::span<const Mode> fixed);

}  // namespace ovws
