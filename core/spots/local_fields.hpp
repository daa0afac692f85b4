/// Fits a bench's deviations from the model over each subaperture to one image.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/base/image.hpp"
#include "core/spots/operating_point.hpp"
#include "core/spots/wavefront_fit.hpp"

namespace ovws {

/// One Gauss-Newton step of `deviations` towards `image`: weighted least squares of the field over
/// each subaperture, its spot's position and background, to the residual of `rendered`. `pass`: fit
/// of the spots. `per_field`: SpotRenderer::per_field. `px_per_wave`: displacement of a spot per
/// wave of tilt at its subaperture's edge. A spot that was not found gets zero intensity.
void take_up_fields(const ImageView& image, const SpotPass& pass,
                    std::span<const RenderedSpot> rendered,
                    std::span<const Eigen::MatrixXf> per_field, const PixelNoise& noise,
                    std::span<const double> px_per_wave, SpotDeviations& deviations);

}  // namespace ovws
