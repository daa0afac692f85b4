/// Builds measurement plans from the sensor's state; too slow for the frame path.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "config/config.hpp"
#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"
#include "core/pipeline/plan.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"
#include "daemon/ovwsd/library/reference.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

struct PlanInputs : SpotBench {
  std::uint64_t sensor_epoch = 0;
  LitPixels lit{};                              ///< pixels of a colour camera that see the laser
  const Reference* reference = nullptr;         ///< null: no reference
  const ModeOperator* mode_operator = nullptr;  ///< null: use slope_operator
  const BeamConfig* beam = nullptr;             ///< the light source; null: the main one
  std::optional<Disc> region{};                 ///< MeasurementPlan::region
};

/// Charge, scale (lambda/d) and lit pixels of the sensor's spots on a camera with this pixel
/// format.
SpotModel spot_model(const SensorConfig& sensor, const OpticsConfig& optics, const SlmGeometry& slm,
                     PixelFormat format);

/// Rotation of all spots about the pupil's centre, as a nuisance column (2N x 1) for Reconstructor.
/// Used for vortices with a model reference (rows of bright spots among them are 0); otherwise
/// empty, because a measured reference contains the rotation. A rotated camera rotates the spots.
/// So does illumination that falls off towards the rim: it moves each vortex core perpendicular to
/// the amplitude's gradient. No wavefront rotates the spots, but while spots are lost the modes
/// would absorb the rotation.
Eigen::MatrixXd rotation_column(const Lattice& lattice, const SensorConfig& sensor,
                                const PxPerCycle& map, const Reference* reference);

/// Errc::invalid (field "tracker"): the tracker is too slow to run on every frame.
Result<void> check_daemon_tracker(const TrackingSettings& tracking);

/// Builds the plans of one sensor, which differ only in their hologram. They share what takes
/// milliseconds to make: tracker, reconstructor and slopes. Not thread-safe.
class PlanBuilder {
 public:
  /// Errors: those of make_tracker.
  static Result<PlanBuilder> make(const PlanInputs& inputs);

  /// Builds the plan for a hologram that shows `aberration`: introduced minus `correction`.
  std::unique_ptr<MeasurementPlan> plan(std::uint64_t id, std::uint64_t hologram_id,
                                        const std::vector<Mode>& aberration,
                                        std::vector<Mode> correction = {});

 private:
  explicit PlanBuilder(const PlanInputs& inputs);
  Eigen::MatrixXd slopes_of(const std::vector<int>& modes_j) const;
  void displace(std::vector<Vec2>& points, const std::vector<Mode>& modes, double sign);

  MeasurementPlan first_;  ///< without a hologram: predicted_px are those of a flat one
  Lattice lattice_;
  SensorConfig sensor_;
  std::vector<double> tilt_radii_;  ///< of the tracker, see slope_matrix
  PxPerCycle px_per_cycle_;
  std::map<int, Eigen::VectorXd> moves_px_;  ///< by mode: displacements of the spots (2N) by 1 wave
};

}  // namespace ovws
