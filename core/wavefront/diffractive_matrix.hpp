/// Diffractive operator: the interaction matrix from modes poked in the diffraction model.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <span>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

struct DiffractiveMatrix {
  /// 2N x Z like that of slope_matrix: camera pixels per RMS-normalised wave.
  Eigen::MatrixXd slopes;
  /// Positions that the tracker finds for a flat wavefront. A spot that it does not find in every
  /// image of the model (for example outside the camera's window) has NaN here and rows of 0; a
  /// Reconstructor never uses it.
  std::vector<Vec2> reference_px;
};

/// Step of the central differences, RMS-normalised waves.
constexpr double kDiffractiveStep = 0.05;

/// Central differences: propagates each mode at +-step through the noise-free model and tracks the
/// spots from where the geometric slope predicts them. Takes 2 Z + 1 propagations, 2 s for 18 modes
/// of the default bench: compute it off the frame path and keep it. One thread at a time per model.
///
/// It is exact for aberrations of about the step. For larger ones slope_matrix is better:
/// aberration inside a subaperture changes the spot's shape, and with it the tracked position, by a
/// term that is cubic in the waves. Isolated spots show the same. No linear matrix reads 0.3 wave
/// of a mode of n >= 3 to 0.005 wave.
///
/// Errors: as of SensorModel::light for too large a step; Errc::refused, field "tracking", if the
/// tracker finds fewer than 3 spots, or if `stop` (may be null) becomes true.
Result<DiffractiveMatrix> diffractive_matrix(SensorModel& model, const SensorConfig& sensor,
                                             const SpotTracker& tracker,
                                             std::span<const int> modes_j,
                                             double step_waves = kDiffractiveStep,
                                             const std::atomic<bool>* stop = nullptr);

/// Tracks the spots of a wavefront in the model, starting where the geometric slope at each
/// subaperture's centre predicts them. A lost spot has NaN. Errors as of SensorModel::light.
Result<std::vector<SpotFix>> model_fixes(SensorModel& model, const SensorConfig& sensor,
                                         const SpotTracker& tracker, std::span<const Mode> modes);

}  // namespace ovws
