/// What a calibration's pictures lack of the spots, put in from what they have.
#pragma once

#include <Eigen/Core>

#include "core/wavefront/interaction_matrix.hpp"

namespace ovws {

/// Puts in the resting spots that the pictures of a mode lost: from the other picture, mirrored at
/// where the spot rests, or, where both lost it, from the model's column (2N camera pixels per
/// wave) times what the other spots moved of theirs. Else the spot would count for no mode. Nothing
/// is put in if more than kMostLostByMode of the spots are lost: interaction_matrix then drops the
/// mode.
void fill_lost(const SpotMeans& resting, const Eigen::Ref<const Eigen::VectorXd>& model,
               PushPull& push);

}  // namespace ovws
