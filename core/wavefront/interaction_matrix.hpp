/// Measured interaction (poke) matrix: each mode is poked push-pull on the bench, and the spots'
/// displacements are its column.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"

namespace ovws {

/// Mean spot positions of one hologram, averaged over frames, camera pixels; NaN: lost.
struct SpotMeans {
  std::vector<Vec2> at_px;
  std::vector<Vec2> standard_error_px;
};

/// Drift of the spots that are found in both of two measurements; 0 if there are none.
struct SpotDrift {
  double rms_px = 0.0;    ///< over x and y
  double noise_px = 0.0;  ///< expected from the standard errors alone
};
SpotDrift drift_between(const SpotMeans& first, const SpotMeans& second);
/// Mean of two measurements of one hologram. A spot lost in either measurement is lost.
SpotMeans mean_of_both(const SpotMeans& first, const SpotMeans& second);

/// Push-pull poke of one mode, added to the hologram that is shown.
struct PushPull {
  int j = 0;
  double amplitude_waves = 0.0;  ///< RMS-normalised
  SpotMeans plus, minus;         ///< spots with +amplitude and with -amplitude
};

/// All measurements of a calibration run. Every SpotMeans has the same number of spots.
struct PushPullRun {
  SpotMeans before, after;  ///< spots at rest (no poke), at the start and the end
  std::vector<PushPull> modes;
};

/// A mode is dropped if its pokes lose more than this share of the resting spots.
constexpr double kMaxLostByMode = 0.25;

struct DroppedMode {
  int j = 0;
  std::string reason;  ///< human-readable
};

/// Who measured the matrix: the daemon, or a client with a corrector of its own.
enum class MatrixSource { run, set };

struct InteractionMatrix {
  std::vector<int> modes_j;             ///< OSA index of each column
  std::vector<double> amplitude_waves;  ///< poke amplitude of each column, RMS-normalised
  /// 2N x Z matrix as from slope_matrix: camera pixels per RMS-normalised wave.
  Eigen::MatrixXd slopes;
  Eigen::MatrixXd standard_error;    ///< of each element of `slopes`
  std::vector<int> lost_spots;       ///< indices of spots that are not used; their rows are 0
  std::vector<DroppedMode> dropped;  ///< requested modes that have no column
  double drift_px = 0.0;             ///< RMS over x and y, between `before` and `after`
  double drift_noise_px = 0.0;       ///< expected from the standard errors alone
  MatrixSource source = MatrixSource::run;

  int spots() const { return int(slopes.rows() / 2); }
};

/// Interaction matrix from pokes: each column is (plus - minus) / (2 amplitude). A mode is dropped
/// if its pokes lose more than kMaxLostByMode of the spots, if its noise exceeds a tenth of its
/// signal, or if it is not determined together with the preceding modes: condition number above
/// 1000, or a singular value below ten times its noise. A spot that is lost in any image of the
/// remaining modes has rows of 0 in every column, because a Reconstructor uses a spot for all modes
/// or for none.
///
/// Errors (Errc::refused): the resting spots drifted by more than `max_drift_px`; fewer than 3
/// spots, or no mode, remain.
Result<InteractionMatrix> interaction_matrix(const PushPullRun& run, double max_drift_px);

/// Interaction matrix of a client that has measured its columns itself: camera pixels per
/// RMS-normalised wave, and their standard errors, 2N x Z each. A spot whose rows are all 0 is
/// lost.
///
/// Errors (Errc::refused, field "matrix"): fewer than 3 spots remain; the standard error of a mode
/// exceeds a tenth of its signal, or the spots cannot distinguish it from the modes before it.
Result<InteractionMatrix> interaction_matrix(const std::vector<int>& modes_j,
                                             double amplitude_waves, const Eigen::MatrixXf& slopes,
                                             const Eigen::MatrixXf& standard_error);

/// Indices of spots that are found at rest but lost in an image of the poke. A smaller amplitude
/// may keep them.
std::vector<int> lost_by(const PushPull& poke, const SpotMeans& resting);

/// Fills in spots that are found at rest but lost in a poke's images, because a lost spot cannot be
/// used for any mode. A spot lost in one image is mirrored from the other image about its resting
/// position. A spot lost in both images moves as in the model's column (2N camera pixels per wave),
/// scaled to the measured motion of the other spots. Nothing is filled in if more than
/// kMaxLostByMode of the spots are lost: interaction_matrix then drops the mode.
void fill_lost(const SpotMeans& resting, const Eigen::Ref<const Eigen::VectorXd>& model,
               PushPull& poke);

/// Noise-to-signal ratio of column `k`: norm of its standard errors over its own norm.
double relative_noise(const InteractionMatrix& matrix, Eigen::Index k);

}  // namespace ovws
