/// Builds measurement plans from the sensor's state. Pure functions, too slow for the frame path.
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
#include "proto/tables/sensor.hpp"

namespace ovws {

struct PlanInputs {
  std::uint64_t id = 0;
  std::uint64_t sensor_epoch = 0;
  std::uint64_t hologram_id = 0;  ///< the hologram that shows `aberration`
  const Lattice& lattice;
  const SensorConfig& sensor;
  const TrackingSettings& tracking;
  const OpticsConfig& optics;
  const SlmGeometry& slm;
  const Roi& roi;
  PixelFormat format = PixelFormat::mono8;
  LitPixels lit{};                              ///< pixels of a colour camera that see the laser
  const std::vector<Mode>& aberration;          ///< shown on the SLM: introduced minus correction
  const Reference* reference = nullptr;         ///< null: no reference
  const ModeOperator* mode_operator = nullptr;  ///< null: use slope_operator
};

/// Charge, scale (lambda/d) and lit pixels of the sensor's spots on a camera with this pixel
/// format.
SpotModel spot_model(const SensorConfig& sensor, const OpticsConfig& optics, const SlmGeometry& slm,
                     PixelFormat format);

/// Rotation of all spots about the pupil's centre, as a nuisance column (2N x 1) for Reconstructor.
/// Used for vortices with a model reference; otherwise empty, because a measured reference contains
/// the rotation. A rotated camera rotates the spots. So does illumination that falls off towards
/// the rim: it moves each vortex core perpendicular to the amplitude's gradient. No wavefront
/// rotates the spots, but while spots are lost the modes would absorb the rotation.
Eigen::MatrixXd rotation_column(const Lattice& lattice, const SensorConfig& sensor,
                                const PxPerCycle& map, const Reference* reference);

/// Errc::invalid (field "tracker"): the tracker is too slow to run on every frame.
Result<void> check_daemon_tracker(const TrackingSettings& tracking);

/// Reports that the obsolete setting `template` has no effect, if it is set.
TemplateReport template_report(const TrackingSettings& tracking);

/// Builds the plan that measures frames. Errors: those of make_tracker.
Result<std::unique_ptr<MeasurementPlan>> build_plan(const PlanInputs& inputs);

}  // namespace ovws
