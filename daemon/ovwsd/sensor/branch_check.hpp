/// Branch points of the light in spots that shall become a reference, and how to name them.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "core/wavefront/branch_points.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"
#include "daemon/ovwsd/sensor/spot_average.hpp"

namespace ovws {

/// Where the first of `count` branch points is, for a message.
std::string branch_point_text(int count, const BranchPoint& first);

/// Checks that the light of these spots has no branch points, as the pipeline checks a frame, but
/// against the spots of a flat wavefront. A reference with a branch point would hide it: later
/// frames without it would be wrong. Errc::refused. The check passes if more than a sixth of the
/// spots are lost, or if those found do not determine the modes.
Result<void> check_branch_points(const SpotAverage& average, const SensorState& state,
                                 const BenchOptics& optics);

}  // namespace ovws
