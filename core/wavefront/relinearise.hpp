/// Relinearised reconstruction: Gauss-Newton iterations about the current estimate.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

struct Relinearised {
  std::vector<double> waves;     ///< in the order of modes_j, RMS-normalised
  double last_step_waves = 0.0;  ///< root sum square of the last correction
  double fit_residual_px = 0.0;  ///< of the last step, see Reconstruction
};

/// Gauss-Newton iteration a <- a + P (measured - spots of the model at a), `steps` times. P is the
/// pseudo-inverse of `slopes`; slope_matrix suffices, because a step also corrects its error. Each
/// step takes one propagation of about 50 ms and leaves about a tenth of the error. From 0.3 wave
/// of one mode two steps reach 0.003 wave if no spot is lost. Refiner needs no tracked spots and
/// reaches further.
///
/// `fixes` are those of an ideal sensor: found minus the measured reference plus the model's.
/// `start`: the linear estimate, in the order of modes_j. Errors: as of SensorModel::light;
/// Errc::refused, field "tracking", if the spots found in both image and model do not determine the
/// modes.
Result<Relinearised> relinearise(SensorModel& model, const SensorConfig& sensor,
                                 const SpotTracker& tracker, const Eigen::MatrixXd& slopes,
                                 std::span<const int> modes_j, std::span<const SpotFix> fixes,
                                 std::span<const float> start, int steps = 2);

}  // namespace ovws
