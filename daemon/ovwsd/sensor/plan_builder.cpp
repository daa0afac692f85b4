#include "daemon/ovwsd/sensor/plan_builder.hpp"

#include <Eigen/Core>

#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

Eigen::MatrixXd slopes_of(const PlanInputs& inputs, const std::vector<int>& modes_j) {
  return slope_matrix(inputs.lattice, inputs.sensor, modes_j,
                      tilt_radius(inputs.sensor.charge, inputs.tracking),
                      px_per_cycle(inputs.optics, inputs.slm));
}

/// Displacement of every spot by `modes`, computed with the slope matrix, camera pixels.
std::vector<Vec2> displacements(const PlanInputs& inputs, const std::vector<Mode>& modes) {
  std::vector<int> modes_j;
  Eigen::VectorXd waves(Eigen::Index(modes.size()));
  for (std::size_t i = 0; i < modes.size(); ++i) {
    modes_j.push_back(modes[i].j);
    waves[Eigen::Index(i)] = modes[i].waves;
  }
  const Eigen::VectorXd moved = slopes_of(inputs, modes_j) * waves;
  std::vector<Vec2> result;
  for (Eigen::Index i = 0; i + 1 < moved.size(); i += 2) result.push_back({moved[i], moved[i + 1]});
  return result;
}

void add(std::vector<Vec2>& points, const std::vector<Vec2>& moves, double sign) {
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = points[i] + sign * moves[i];
}

std::vector<Vec2> predicted(const PlanInputs& inputs) {
  if (inputs.reference == nullptr) {
    auto spots = model_spots_px(inputs.lattice, inputs.sensor, inputs.slm, inputs.optics,
                                inputs.roi.width, inputs.roi.height);
    add(spots, displacements(inputs, inputs.aberration), 1.0);
    return spots;
  }
  auto spots = inputs.reference->positions_px;
  add(spots, displacements(inputs, inputs.aberration), 1.0);
  add(spots, displacements(inputs, inputs.reference->aberration), -1.0);
  return spots;
}

/// Modes of the plan: first those that spot positions determine, then those that only templates
/// determine.
std::vector<int> measured_modes(const TrackingSettings& tracking, const ModeOperator& positions) {
  if (positions.shapes) return positions.shapes->modes_j;
  const bool measured = positions.kind == OperatorKind::measured;
  return measured ? positions.modes_j : with_shapes(tracking, positions.modes_j);
}

}  // namespace

SpotModel spot_model(const SensorConfig& sensor, const OpticsConfig& optics, const SlmGeometry& slm,
                     PixelFormat format) {
  return {sensor.charge, lambda_d_px(optics, slm, sensor),
          lit_pixels(format, optics.wavelength_nm)};
}

Eigen::MatrixXd rotation_column(const Lattice& lattice, const SensorConfig& sensor,
                                const PxPerCycle& map, const Reference* reference) {
  const bool of_model = reference != nullptr && reference->source == ReferenceSource::model;
  if (!of_model || sensor.charge == 0) return {};
  const auto& spots = lattice.subapertures;
  const double diameter_px = sensor.pupil_diameter_px;
  Eigen::MatrixXd column(2 * Eigen::Index(spots.size()), 1);
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Vec2 at = (4.0 / (diameter_px * diameter_px)) * spots[i].centre_px;
    const Vec2 moved = map * Vec2{-at.y, at.x};  // tilt of one wave per radius at the rim
    column(2 * Eigen::Index(i), 0) = moved.x;
    column(2 * Eigen::Index(i) + 1, 0) = moved.y;
  }
  return column;
}

Result<void> check_daemon_tracker(const TrackingSettings& tracking) {
  if (tracking.tracker == TrackerKind::lg_contour) {
    return fail(Errc::invalid, "tracker",
                "lg_contour is too slow for the daemon and works offline only: use lg, which finds "
                "the same positions");
  }
  return {};
}

TemplateReport template_report(const TrackingSettings& tracking) {
  if (tracking.templates == TemplateKind::model) return {};
  return {0, "template has no effect any more: fit takes the spots' shapes from the reference"};
}

Result<std::unique_ptr<MeasurementPlan>> build_plan(const PlanInputs& inputs) {
  auto plan = std::make_unique<MeasurementPlan>();
  plan->id = inputs.id;
  plan->sensor_epoch = inputs.sensor_epoch;
  plan->hologram_id = inputs.hologram_id;
  plan->charge = inputs.sensor.charge;
  plan->tracker_kind = inputs.tracking.tracker;
  plan->spots = {inputs.sensor.charge, lambda_d_px(inputs.optics, inputs.slm, inputs.sensor),
                 inputs.lit};
  plan->roi = inputs.roi;
  plan->format = inputs.format;
  plan->predicted_px = predicted(inputs);
  if (inputs.reference != nullptr) {
    plan->reference_px = known_positions(*inputs.reference);
    plan->reference_introduced_rms_waves = rms_waves(inputs.reference->introduced);
  }
  auto tracker = make_tracker(inputs.tracking, plan->spots);
  if (!tracker) return fail(tracker.error());
  plan->tracker = std::move(*tracker);
  const ModeOperator& modes = inputs.mode_operator != nullptr
                                  ? *inputs.mode_operator
                                  : slope_operator(inputs.lattice, inputs.sensor, inputs.tracking,
                                                   px_per_cycle(inputs.optics, inputs.slm));
  plan->mode_operator = modes.kind;
  plan->modes_j = measured_modes(inputs.tracking, modes);
  plan->fits_shapes = inputs.tracking.tracker == TrackerKind::fit &&
                      (modes.kind != OperatorKind::measured || modes.shapes);
  // A calibration with shapes measures displacements of whole spots. They differ from the tracker's
  // positions, so the model's slopes are used.
  plan->reconstructor = std::make_unique<Reconstructor>(
      modes.shapes ? slopes_of(inputs, modes.modes_j) : modes.slopes, modes.modes_j,
      plan->reference_px,
      rotation_column(inputs.lattice, inputs.sensor, px_per_cycle(inputs.optics, inputs.slm),
                      inputs.reference));
  return plan;
}

}  // namespace ovws
