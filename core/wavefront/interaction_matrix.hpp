/// The sensor's interaction matrix as the bench shows it: each mode is pushed and pulled, and the
/// spots' displacements are the mode's column.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/wavefront/mode_operator.hpp"

namespace ovws {

/// Spots of one picture, averaged over frames, camera pixels; NaN: lost.
struct SpotMeans {
  std::vector<Vec2> at_px;
  std::vector<Vec2> standard_error_px;
};

/// One mode, shown on top of what else is shown.
struct PushPull {
  int j = 0;
  double amplitude_waves = 0.0;  ///< RMS-normalised
  SpotMeans plus, minus;         ///< with +amplitude, -amplitude
};

/// All pictures of a run. Every SpotMeans has as many spots.
struct PushPullRun {
  SpotMeans before, after;  ///< without any push
  std::vector<PushPull> modes;
};

/// A mode that loses more than this share of the spots that are there without a push is dropped.
constexpr double kMostLostByMode = 0.25;

struct DroppedMode {
  int j = 0;
  std::string reason;  ///< for a person
};

struct InteractionMatrix {
  std::vector<int> modes_j;             ///< of the columns
  std::vector<double> amplitude_waves;  ///< the columns were measured with, RMS-normalised
  /// 2N x Z like that of slope_matrix: camera pixels per RMS-normalised wave.
  Eigen::MatrixXd slopes;
  Eigen::MatrixXd standard_error;    ///< of each of its numbers
  std::vector<int> lost_spots;       ///< their rows are 0: they tell nothing
  std::vector<DroppedMode> dropped;  ///< modes that were asked for, and have no column
  double drift_px = 0.0;             ///< RMS over x and y, from before to after
  double drift_noise_px = 0.0;       ///< what the drift's standard errors alone make of it

  int spots() const { return int(slopes.rows() / 2); }
};

/// Column = (plus - minus) / (2 amplitude). A mode is dropped if it loses more than
/// kMostLostByMode of the spots, if its noise is over a tenth of its signal, or if with
/// it the modes before it are no longer determined: condition over 1000, or a singular value below
/// ten times its noise. A spot that is lost in any picture of the modes that stay has rows of 0 in
/// every column, for a Reconstructor uses a spot for all modes or for none. Errors (Errc::refused):
/// the zero drifted by more than `most_drift_px`; fewer than 3 spots, or no mode, are left.
Result<InteractionMatrix> interaction_matrix(const PushPullRun& run, double most_drift_px);

/// Spots that are there without a push, and not in one of the mode's pictures: a smaller push may
/// keep them.
std::vector<int> lost_by(const PushPull& push, const SpotMeans& resting);

/// Largest first, camera pixels per RMS-normalised wave.
Eigen::VectorXd singular_values(const InteractionMatrix& matrix);
/// Noise over signal of column `k`: root sum squares of its standard errors and of itself.
double relative_noise(const InteractionMatrix& matrix, Eigen::Index k);

/// For a plan; kind `measured`.
ModeOperator mode_operator_of(const InteractionMatrix& matrix);

}  // namespace ovws
