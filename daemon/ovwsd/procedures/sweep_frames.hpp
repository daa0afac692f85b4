/// What the frames of a gain sweep's cell tell: pure computation.
#pragma once

#include <vector>

#include "core/optics/zernike.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovwsd/frames/frame_series.hpp"
#include "proto/tables/experiment.hpp"

namespace ovws {

/// Where each spot is on average; NaN if it is found in fewer than half of the frames.
std::vector<Vec2> mean_positions(const std::vector<SeriesFrame>& frames);
SpotLevels levels_of(const std::vector<SeriesFrame>& frames);
/// Each frame's modes, and how far they are from `introduced`.
std::vector<CellMeasured::Frame> judge_frames(const std::vector<SeriesFrame>& frames,
                                              const Reconstructor& reconstructor,
                                              const std::vector<Mode>& introduced);

}  // namespace ovws
