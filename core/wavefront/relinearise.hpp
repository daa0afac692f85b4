/// Modes from displacements that are not linear in them: what the linear estimate leaves, measured
/// again from where the model puts the spots of that estimate.
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
  double last_step_waves = 0.0;  ///< root sum square of the last correction: how far it had to go
  double fit_residual_px = 0.0;  ///< of the last step, see Reconstruction
};

/// a <- a + P (measured - spots of the model at a), `steps` times, P the pseudo-inverse of `slopes`
/// (slope_matrix will do: a step corrects its own slope too). Each step is one propagation of some
/// 50 ms and leaves about a tenth of the error. From 0.3 wave of one mode two steps come to 0.003
/// wave as long as no spot is lost; refine() needs no spots and goes further.
///
/// `fixes` as of the ideal sensor: found minus the measured reference plus the model's. `start` are
/// modes in the order of modes_j, the linear estimate. Errors: as of SensorModel::light;
/// Errc::refused, field "tracking", if the spots that both image and model show determine no modes.
Result<Relinearised> relinearise(SensorModel& model, const SensorConfig& sensor,
                                 const SpotTracker& tracker, const Eigen::MatrixXd& slopes,
                                 std::span<const int> modes_j, std::span<const SpotFix> fixes,
                                 std::span<const float> start, int steps = 2);

}  // namespace ovws
