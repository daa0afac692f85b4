/// Colour-plane sampling: tracks spots on the lit colour planes of a Bayer camera.
#pragma once

#include <memory>

#include "core/tracking/tracker.hpp"

namespace ovws {

/// Wraps `tracker`, which is made for SpotModel::on_plane, so that it sees the lit pixels alone;
/// starts and fixes are camera pixels. With two lit planes (green) the fix is the mean of both, or
/// the only one found; fixes that disagree by more than 0.4 lambda/d along x or y are lost. Returns
/// `tracker` itself if all pixels are lit.
std::unique_ptr<const SpotTracker> on_plane(std::unique_ptr<const SpotTracker> tracker,
                                            const SpotModel& spots);

}  // namespace ovws
