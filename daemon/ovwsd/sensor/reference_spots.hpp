/// Which spots a reference knows, and which modes they determine: a spot that is lost costs
/// information, not the reference.
#pragma once

#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/spot_average.hpp"

namespace ovws {

struct ReferenceSpots {
  std::vector<int> lost;          ///< found in fewer than half of the frames: it has no reference
  std::vector<int> weak;          ///< found in fewer than nine of ten frames
  std::vector<int> weak_modes_j;  ///< their noise is more than kWeakGrowth times that of all spots
};

/// A mode is weak if the lost spots raise its noise by more than this.
constexpr double kWeakGrowth = 1.5;

/// Errors (Errc::refused): without the lost spots a mode is not determined, by the criterion of
/// Reconstructor. `modes`: as many spots as `average`.
Result<ReferenceSpots> judge_spots(const SpotAverage& average,
                                   const ModeOperator& modes);

/// Gives lost spots the place where the model and the affine displacement of the others have them,
/// for trackers to look at; their standard error is not a number. `model_px`: one a spot.
void place_lost(const std::vector<int>& lost, const std::vector<Vec2>& model_px,
                Reference& reference);

/// What displacements count from: not a number where a spot was lost.
std::vector<Vec2> known_positions(const Reference& reference);

}  // namespace ovws
