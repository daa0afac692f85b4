/// What a bench does differently from the model over each subaperture, from one image.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/base/image.hpp"
#include "core/spots/operating_point.hpp"
#include "core/spots/wavefront_fit.hpp"

namespace ovws {

/// One step (Gauss-Newton) of `deviations` towards what `image` shows: weighted least squares of
/// the field over each subaperture, its position and its background, against what the rendering of
/// `pass` leaves. `per_field`: SpotRenderer::per_field. `px_per_wave`: by which a tilt of one wave
/// at the edge of a subaperture moves its spot. A spot that was not found has no light.
void take_up_fields(const ImageView& image, const SpotPass& pass,
                    std::span<const RenderedSpot> rendered,
                    std::span<const Eigen::MatrixXf> per_field, const PixelNoise& noise,
                    std::span<const double> px_per_wave, SpotDeviations& deviations);

}  // namespace ovws
