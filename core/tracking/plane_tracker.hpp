/// Colour-plane sampling: tracks spots on the lit colour planes of a Bayer camera.
#pragma once

#include <memory>

#include "core/tracking/tracker.hpp"

namespace ovws {

/// Colour-plane tracker: runs `tracker`, which is made for SpotModel::on_plane, on the lit pixels
/// alone. Starts and fixes are camera pixels. With two lit planes (green) the result is the mean of
/// the two fixes, or the only fix found. The spot is lost if the fixes differ by more than 0.4
/// lambda/d along x or y. Returns `tracker` itself if all pixels are lit.
std::unique_ptr<const SpotTracker> on_plane(std::unique_ptr<const SpotTracker> tracker,
                                            const SpotModel& spots);

}  // namespace ovws
