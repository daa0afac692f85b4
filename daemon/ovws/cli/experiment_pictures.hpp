/// Pictures of a gain sweep: what the camera saw, and what wavefront is left.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/result.hpp"

namespace ovws::cli {

/// Results of experiment.cell by number.
using SweepCells = std::map<int, nlohmann::json>;

/// experiment-images-charge-L.png for each charge of which frames were kept: the frames side by
/// side, as bright as they were. Errors: a file cannot be written.
Result<void> draw_camera_frames(const SweepCells& cells, const std::filesystem::path& folder);

/// experiment-residual.png, as in the paper at the measured gain next to 36 dB: the second
/// aberration (or the only one), and for each arm the residual wavefront of the frame whose
/// variance is the median of its cell, in the introduced one's colours. Nothing if no cell was
/// measured there.
Result<void> draw_residuals(const nlohmann::json& request, const SweepCells& cells,
                            const std::filesystem::path& folder);

}  // namespace ovws::cli
