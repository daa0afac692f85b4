/// From what the sensor is to what a frame is measured with: pure computation, off the frame path.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "config/config.hpp"
#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"
#include "core/pipeline/plan.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/torn_spots.hpp"

namespace ovws {

struct PlanInputs {
  std::uint64_t id = 0;
  std::uint64_t sensor_epoch = 0;
  std::uint64_t hologram_id = 0;  ///< that shows `aberration`
  const Lattice& lattice;
  const SensorConfig& sensor;
  const TrackingConfig& tracking;
  const OpticsConfig& optics;
  const SlmGeometry& slm;
  const Roi& roi;
  PixelFormat format = PixelFormat::mono8;
  LitPixels lit{};                       ///< the camera's, of this optics' wavelength
  const std::vector<Mode>& aberration;   ///< shown on purpose
  const Reference* reference = nullptr;  ///< null: none
  int workers = 0;
  const TornSpots* torn = nullptr;  ///< null: none is
  /// See MatchedTracker; empty: the model's for all.
  std::vector<std::shared_ptr<const TemplateBank>> templates{};
  const ModeOperator* mode_operator = nullptr;  ///< null: slope_operator
};

/// What the spots of this sensor are on a camera of this pixel format.
SpotModel spot_model(const SensorConfig& sensor, const OpticsConfig& optics, const SlmGeometry& slm,
                     PixelFormat format);

/// What turns the spots about the pupil's centre, one column (2N x 1) for Reconstructor's nuisance;
/// empty if positions count from where the bench showed them. Light that falls off towards the rim
/// moves a vortex's core across the gradient of the amplitude, which is a turn of all, and so does
/// a camera that stands askew: no wavefront does, but with spots lost the modes would take it for
/// one.
Eigen::MatrixXd turn_of_spots(const Lattice& lattice, const SensorConfig& sensor,
                              const PxPerCycle& map, const Reference* reference);

/// Errc::invalid (field "tracker", "operator") for what is too slow to run on every frame.
Result<void> check_daemon_tracker(const TrackingSettings& tracking);

/// Errors as of make_tracker.
Result<std::unique_ptr<MeasurementPlan>> build_plan(const PlanInputs& inputs);

}  // namespace ovws
