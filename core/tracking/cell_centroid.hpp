/// Centroid over a fixed subaperture window, as in textbooks and the paper's Shack-Hartmann sensor.
#pragma once

#include <optional>
#include <span>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"

namespace ovws {

/// Centroid of the recorded intensity, background included, over the square of half-width `half_px`
/// around the pixel nearest to `centre`, clipped at the image. None if all pixels are 0.
std::optional<Vec2> cell_centroid(const ImageView& image, Vec2 centre, int half_px);

/// Half-width of a subaperture window, pixels: half the smallest distance between two centres, so
/// that windows hardly overlap.
int cell_half_px(std::span<const Vec2> centres);

}  // namespace ovws
