/// The centroid of a fixed cell: the text-book Shack-Hartmann sensor, and the paper's.
#pragma once

#include <optional>
#include <span>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"

namespace ovws {

/// Centroid of all light as recorded, no background taken off, in the square of half-width
/// `half_px` around the pixel next to `centre`, clipped at the image. None if it is dark.
std::optional<Vec2> cell_centroid(const ImageView& image, Vec2 centre, int half_px);

/// Half the distance of the two nearest of these places: cells of this half-width hardly overlap.
int cell_half_px(std::span<const Vec2> centres);

}  // namespace ovws
