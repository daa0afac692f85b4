/// One pass over an image: every spot is fitted to its rendering, and the modes to all spots.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/spots/spot_fit.hpp"

namespace ovws {

/// Templates of all spots, and their estimates in an image.
struct SpotPass {
  std::vector<SpotTemplates> templates;
  std::vector<SpotEstimates> found;
  double ceiling_dn = 0.0;    ///< camera pixels this far above the background are near saturation
  double higher_waves = 0.0;  ///< RMS of the higher modes that a step allows for

  /// Levels of the spots found, DN of a camera pixel; 0: not found.
  std::vector<double> levels_dn() const;
  /// Median over the spots of excess_intensity: the fraction that the templates do not explain.
  double excess() const;
  /// Standard error of excess() by noise.
  double excess_scatter() const;
  /// Mean chi-squared per binned pixel of the spots found.
  double chi2() const;
};

/// Sums the camera pixels of each binned pixel in a window, DN.
Eigen::VectorXd cells_of(const ImageView& image, const SpotWindow& window);

/// Use of saturated pixels. Their intensity is unknown, but a clipped spot is as symmetric as a
/// whole spot, which suffices for its position.
enum class Saturated { left_out, used };

/// Fits every spot with templates for the levels found in the image. `noise`: of camera pixels.
SpotPass fit_spots(const ImageView& image, std::span<const RenderedSpot> rendered,
                   const PixelNoise& noise, int estimates,
                   Saturated saturated = Saturated::left_out);

/// Weighted least squares over the estimates of all spots: the change of the modes since the
/// rendering, waves, and its covariance. Spots that are too faint, saturated or outside the image
/// are not used. None if the other spots do not determine the modes.
struct WavefrontStep {
  Eigen::VectorXd waves;
  Eigen::MatrixXd covariance;
};
std::optional<WavefrontStep> step_from(const SpotPass& pass);
/// Damped step (Levenberg, 1944; Marquardt, 1963) far from the solution, where some spots do not
/// look as rendered. The variances of a spot grow with its chi-squared, and modes that are hardly
/// determined change little.
std::optional<WavefrontStep> damped_step(const SpotPass& pass);

/// Estimates the RMS of higher modes from the residual that `step` leaves beyond noise. The
/// previous estimate, `pass.higher_waves`, is part of the whitening.
double higher_waves_of(const SpotPass& pass, const WavefrontStep& step);

/// Estimates pixel noise from successive images: half the squared differences of binned pixels as a
/// straight line over intensity. Changes of the light and of the wavefront between the images are
/// removed by least squares (leverages: MacKinnon and White, J. Econometrics 29, 305, 1985). Uses
/// the pair that differs least; of a single image, the estimate below. `rendered` must be near the
/// images.
PixelNoise noise_of(std::span<const ImageView> images, std::span<const RenderedSpot> rendered);
/// Estimates pixel noise from one image with a kernel that removes smooth intensity (Immerkaer,
/// CVIU 64, 300, 1996). The result is too large if lambda/d is below some 8 pixels (of one colour,
/// behind a Bayer filter), because the kernel does not remove spots of that size.
PixelNoise noise_of(const ImageView& image, std::span<const RenderedSpot> rendered);

}  // namespace ovws
