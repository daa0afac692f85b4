/// Images of the gain sweep: camera frames, and residual wavefronts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "daemon/ovws/study/gain_sweep.hpp"

namespace ovws::cli {

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

/// Writes experiment-residual.png, as in the paper, for the gain nearest to 36 dB. Shows the second
/// aberration (or the only one) and each arm's residual wavefront, on one colour scale. The
/// residual comes from the frame with the cell's median variance.
Result<void> draw_residuals(const GainSweep& sweep, const study::SweepCells& cells,
                            const std::filesystem::path& folder);

}  // namespace ovws::cli
