/// Images of a gain sweep: camera frames and residual wavefronts.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/result.hpp"

namespace ovws::cli {

/// Results of experiment.cell by number.
using SweepCells = std::map<int, nlohmann::json>;

/// Writes experiment-images-charge-L.png for each charge with kept frames: the frames side by side,
/// with unscaled grey levels. Errors: a file cannot be written.
Result<void> draw_camera_frames(const SweepCells& cells, const std::filesystem::path& folder);

/// Writes experiment-residual.png, as in the paper, at the measured gain nearest to 36 dB. It shows
/// the second aberration (or the only one) and each arm's residual wavefront for the frame with the
/// cell's median variance, on the same colour scale. Writes nothing if no cell was measured there.
Result<void> draw_residuals(const nlohmann::json& request, const SweepCells& cells,
                            const std::filesystem::path& folder);

}  // namespace ovws::cli
