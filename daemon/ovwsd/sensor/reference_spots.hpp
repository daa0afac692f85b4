/// Lost spots of a reference: which modes the other spots determine, and where trackers should
/// expect the lost spots. A reference with lost spots is still usable.
#pragma once

#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "daemon/ovwsd/library/reference.hpp"
#include "daemon/ovwsd/sensor/spot_average.hpp"

namespace ovws {

struct ReferenceSpots {
  std::vector<int> lost;          ///< found in fewer than half of the frames, or once of several
  std::vector<int> weak;          ///< not lost, but found in fewer than nine of ten frames
  std::vector<int> weak_modes_j;  ///< modes whose noise grows by more than kWeakGrowth
};

/// A mode is weak if the loss of spots raises its noise by more than this factor.
constexpr double kWeakGrowth = 1.5;

/// Classifies spots as lost or weak. Errc::refused: without the lost spots a mode is not
/// determined, by the criterion of Reconstructor. `modes` must have as many spots as `average`.
Result<ReferenceSpots> judge_spots(const SpotAverage& average, const ModeOperator& modes);

/// Checks that spots that are neighbours in the lattice lie beside each other in the same
/// direction, as they do under every wavefront that a tracker can follow. Errc::invalid, field
/// "positions".
Result<void> check_order(const SpotAverage& given, const std::vector<Vec2>& model);

/// Predicts positions for the lost spots, as start points for trackers: where Neighbourhood expects
/// them from the other spots. Sets the standard errors of lost spots to NaN.
/// `model_px`: model position of every spot, camera pixels.
void place_lost(const std::vector<int>& lost, const std::vector<Vec2>& model_px,
                Reference& reference);

/// The reference positions that displacements count from; NaN for spots that were lost.
std::vector<Vec2> known_positions(const Reference& reference);

}  // namespace ovws
