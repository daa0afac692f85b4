/// A tracker for cameras of which only some pixels see the spots.
#pragma once

#include <memory>

#include "core/tracking/tracker.hpp"

namespace ovws {

/// `tracker`, made for SpotModel::on_lattice, on the lit pixels alone; starts and fixes are the
/// camera's pixels. Where two lattices are lit (green) the fix is the mean of both, or that of one
/// if the other has none; two that contradict one another are none. All pixels lit: `tracker`
/// itself.
std::unique_ptr<const SpotTracker> on_lattice(std::unique_ptr<const SpotTracker> tracker,
                                              const SpotModel& spots);

}  // namespace ovws
