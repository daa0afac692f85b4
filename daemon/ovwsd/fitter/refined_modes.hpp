/// Refinement: a fit of all pixels with a known camera noise model, and a check whether the result
/// is credible. For image files and live frames.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/control/refine_settings.hpp"
#include "core/spots/point_model.hpp"

namespace ovws {

/// Noise model of the camera's pixels: read noise, shot noise and saturation, in DN.
PixelNoise pixel_noise(const RefineCamera& camera);

/// Camera noise model for a frame of this format and gain (amplitude gain 10^(gain_db/20)).
/// `stated` must contain electrons_per_dn.
RefineCamera refine_camera(const RefineSetup& stated, PixelFormat format, double gain_db);

/// Quantisation noise of rounding to whole DN, electrons RMS.
inline double rounding_e(double electrons_per_dn) {
  return electrons_per_dn / std::sqrt(12.0);
}

struct RefinedModes {
  std::vector<double> waves;        ///< requested modes; after `refine` minus the reference's
  std::vector<double> sigma_waves;  ///< standard errors, with the reference's contribution
  double chi2_per_pixel = 0.0;      ///< about 1 if the model explains the image
  double peak_e = 0.0;              ///< model's brightest pixel above background, electrons
  double background_e = 0.0;        ///< electrons per pixel, above the black level
  int iterations = 0;
  /// RMS of modes above the measured ones, whose effect `sigma_waves` includes; 0: there are none.
  double higher_waves = 0.0;
  std::vector<double> amplitudes{};  ///< field of each subaperture, RMS 1; 0: no spot

  /// Why the result is not credible, as a message; none: it is credible. Reasons: no signal, too
  /// few photons for the modes, or a model that does not explain the image.
  std::optional<std::string> doubt(const RefineCamera& camera) const;
};

/// Iterative fit of the modes, begun at each of `starts` until one converges. Every iteration
/// renders all spots, which takes some 10 ms on the default bench. `fixed`: modes shown that are
/// not measured. `templates`: those of an earlier image of this model, or null. If they are exact
/// for this image, too, they are used without an iteration; else they are replaced. Errors: those
/// of PointModel::templates.
Result<RefinedModes> refine(PointModel& model, const ImageView& image, const RefineCamera& camera,
                            PointModel::Starts starts, std::span<const Mode> fixed,
                            std::shared_ptr<const FrameFit>& templates);

/// Iterative fit of the modes without a reference: coefficients count from the model's flat
/// wavefront. The model first learns from the image how the bench deviates over each subaperture.
/// Takes some tenths of a second. Errors: those of PointModel::templates and
/// PointModel::use_reference; Errc::refused, field "image": modes above the measured ones occur.
Result<RefinedModes> refine_absolute(PointModel& model, const ImageView& image,
                                     const RefineCamera& camera, PointModel::Starts starts,
                                     std::span<const Mode> fixed);

}  // namespace ovws
