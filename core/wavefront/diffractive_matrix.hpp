/// How far each spot moves for each mode, as the tracker in use sees it in the diffraction model.
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
  /// Where the tracker finds each spot of the flat sensor. A spot that it does not find in all of
  /// the model's images (outside the camera's window, say) has NaN here and rows of 0: for a
  /// Reconstructor it is always lost.
  std::vector<Vec2> reference_px;
};

/// Step of the differences, RMS-normalised waves.
constexpr double kDiffractiveStep = 0.05;

/// Central differences: each mode at +-step through the model, free of noise, tracked from where
/// the geometric slope predicts each spot. 2 Z + 1 propagations, 2 s for 18 modes of the default
/// bench: prepare it off the frame path and keep it. One thread at a time for a model.
///
/// It is the truth for aberrations of about the step. For larger ones slope_matrix is better: the
/// aberration inside a subaperture changes the spot's shape, and with it what the tracker takes for
/// its place, with a part that is cubic in the waves. Spots without neighbours show the same. No
/// linear matrix reads 0.3 wave of a mode of n >= 3 to 0.005 wave: see relinearise.
///
/// Errors: as of SensorModel::light for too large a step; Errc::refused, field "tracking", if the
/// tracker finds fewer than 3 spots, or if `stop`, when not null, became true meanwhile.
Result<DiffractiveMatrix> diffractive_matrix(SensorModel& model, const SensorConfig& sensor,
                                             const SpotTracker& tracker,
                                             std::span<const int> modes_j,
                                             double step_waves = kDiffractiveStep,
                                             const std::atomic<bool>* stop = nullptr);

/// Where the tracker finds each spot of a wavefront in the model; a lost one has NaN. Errors as of
/// SensorModel::light. The geometric slope at each subaperture's centre predicts where to look.
Result<std::vector<SpotFix>> model_fixes(SensorModel& model, const SensorConfig& sensor,
                                         const SpotTracker& tracker, std::span<const Mode> modes);

}  // namespace ovws
