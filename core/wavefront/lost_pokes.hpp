/// Fills in spots that were lost during push-pull pokes.
#pragma once

#include <Eigen/Core>

#include "core/wavefront/interaction_matrix.hpp"

namespace ovws {

/// Fills in the resting spots that a poke's images lost. A spot lost in one image is mirrored from
/// the other image about its resting position. A spot lost in both images moves as in the model's
/// column (2N camera pixels per wave), scaled to the measured motion of the other spots. Otherwise
/// the spot could not be used for any mode. Nothing is filled in if more than kMaxLostByMode of
/// the spots are lost: interaction_matrix then drops the mode.
void fill_lost(const SpotMeans& resting, const Eigen::Ref<const Eigen::VectorXd>& model,
               PushPull& poke);

}  // namespace ovws
