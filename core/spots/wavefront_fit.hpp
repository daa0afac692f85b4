/// One pass over an image: every spot is fitted to its rendering, and the modes to all spots.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/spots/spot_fit.hpp"

namespace ovws {

/// Templates of all spots, and what they find in an image.
struct SpotPass {
  std::vector<SpotTemplates> templates;
  std::vector<SpotEstimates> found;
  double ceiling_dn = 0.0;    ///< of a camera pixel above the background: saturation is near
  double higher_waves = 0.0;  ///< RMS of higher_modes that a step allows for

  /// Levels of the spots found, DN of a camera pixel; 0: not found.
  std::vector<double> levels_dn() const;
  /// Median over the spots of the weighted light that the templates leave beyond noise, relative.
  double excess() const;
  /// Its standard error by noise.
  double excess_scatter() const;
  /// Mean chi-squared per cell of the spots found.
  double chi2() const;
};

/// The sum over the pixels of each cell, DN.
Eigen::VectorXd cells_of(const ImageView& image, const SpotWindow& window);

/// Cells near the full scale: their intensity is unknown, but a clipped spot is as symmetric as a
/// whole one.
enum class Saturated { left_out, used };

/// Makes the templates for the levels that the spots have in the image. `noise` is the pixels'.
SpotPass fit_spots(const ImageView& image, std::span<const RenderedSpot> rendered,
                   const PixelNoise& noise, int estimates,
                   Saturated saturated = Saturated::left_out);

/// Weighted least squares over the estimates of all spots: the change of the modes since the
/// rendering, waves, and its covariance. Spots without a level are not used. None if the rest does
/// not determine the modes.
struct WavefrontStep {
  Eigen::VectorXd waves;
  Eigen::MatrixXd covariance;
};
std::optional<WavefrontStep> step_from(const SpotPass& pass);
/// The same for steps from far away, where some spots do not look as rendered: their variances
/// grow with their chi-squared, and modes that the other spots hardly determine change little
/// (Levenberg, 1944; Marquardt, 1963).
std::optional<WavefrontStep> damped_step(const SpotPass& pass);

/// higher_waves as the estimates tell it: what the step leaves of them beyond noise. The pass
/// allows for some already.
double higher_waves_of(const SpotPass& pass, const WavefrontStep& step);

/// The noise of pixels, from two or more images in a row: half the squared differences of cells as
/// a straight line over their light. Uses the two successive images that differ least, because the
/// light may change between others. Shot noise needs `rendered` to be near the images.
PixelNoise noise_of(std::span<const ImageView> images, std::span<const RenderedSpot> rendered);
/// The same from one image: what a kernel leaves that takes out all smooth light (Immerkaer, CVIU
/// 64, 300, 1996). Too large where lambda/d is below some 8 pixels, which the kernel does not take
/// out.
PixelNoise noise_of(const ImageView& image, std::span<const RenderedSpot> rendered);

}  // namespace ovws
