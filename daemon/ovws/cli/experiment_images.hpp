/// Images of the gain sweep: camera frames, and residual wavefronts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws::cli {

/// Results of the measured cells by number, by report_of.
using SweepCells = std::map<int, nlohmann::json>;

/// One frame of a charge at a gain.
struct CameraFrame {
  int charge = 0;
  double gain_db = 0.0, peak_dn = 0.0;
  Image<std::uint8_t> image;  ///< 255: the format's full scale
};
using CameraFrames = std::vector<CameraFrame>;

/// Writes experiment-images-charge-L.png for each charge L that has frames. It shows these frames
/// side by side, with unscaled grey levels. Errors: a file cannot be written.
Result<void> draw_camera_frames(const CameraFrames& frames, const std::filesystem::path& folder);

/// Writes experiment-residual.png, as in the paper, for the measured gain nearest to 36 dB. Shows
/// the second aberration (or the only one) and each arm's residual wavefront, on one colour scale.
/// The residual comes from the frame with the cell's median variance. Writes nothing if no cell was
/// measured at this gain.
Result<void> draw_residuals(const nlohmann::json& request, const SweepCells& cells,
                            const std::filesystem::path& folder);

}  // namespace ovws::cli
