/// Evaluates the frames of one cell of a gain sweep. Pure functions.
#pragma once

#include <vector>

#include "core/optics/zernike.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovwsd/frames/frame_series.hpp"
#include "proto/tables/experiment.hpp"

namespace ovws {

/// Mean position of each spot; NaN if it is found in fewer than half of the frames.
std::vector<Vec2> mean_positions(const std::vector<SeriesFrame>& frames);
/// Median level and noise of the found spots, and the brightest pixel.
SpotLevels levels_of(const std::vector<SeriesFrame>& frames);
/// Reconstructs each frame's modes and their residual variance against `introduced`.
std::vector<CellMeasured::Frame> judge_frames(const std::vector<SeriesFrame>& frames,
                                              const Reconstructor& reconstructor,
                                              const std::vector<Mode>& introduced);

}  // namespace ovws
