#include "daemon/ovwsd/sensor/plan_builder.hpp"

#include <Eigen/Core>
#include <algorithm>

#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

/// Modes of the plan: first those that spot positions determine, then those that only templates
/// determine.
std::vector<int> measured_modes(const TrackingSettings& tracking, const ModeOperator& positions) {
  if (positions.shapes) return positions.shapes->modes_j;
  const bool measured = positions.kind == OperatorKind::measured;
  return measured ? positions.modes_j : with_shapes(tracking, positions.modes_j);
}

/// The first `most` modes, unless a calibration has measured the shapes of all.
ModeOperator limited(ModeOperator modes, std::optional<int> most) {
  if (!most || modes.shapes || std::size_t(*most) >= modes.modes_j.size()) return modes;
  modes.modes_j.resize(std::size_t(*most));
  modes.slopes.conservativeResize(Eigen::NoChange, *most);
  return modes;
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
  const auto& spots = lattice.subapertures;
  const bool bright = std::all_of(spots.begin(), spots.end(),
                                  [](const Subaperture& one) { return one.charge == 0; });
  if (!of_model || bright) return {};
  const double diameter_px = sensor.pupil_diameter_px;
  Eigen::MatrixXd column(2 * Eigen::Index(spots.size()), 1);
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const int charge = spots[i].charge;
    const double sign = charge == 0 ? 0.0 : charge < 0 ? -1.0 : 1.0;
    const Vec2 at = (sign * 4.0 / (diameter_px * diameter_px)) * spots[i].centre_px;
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

PlanBuilder::PlanBuilder(const PlanInputs& inputs)
    : lattice_(inputs.lattice),
      sensor_(inputs.sensor),
      tilt_radii_(tilt_radii(inputs.lattice, inputs.tracking)),
      px_per_cycle_(px_per_cycle(inputs.optics, inputs.slm)) {}

Eigen::MatrixXd PlanBuilder::slopes_of(const std::vector<int>& modes_j) const {
  return slope_matrix(lattice_, sensor_, modes_j, tilt_radii_, px_per_cycle_);
}

/// Displaces every spot by `modes`, computed with the slope matrix.
void PlanBuilder::displace(std::vector<Vec2>& points, const std::vector<Mode>& modes, double sign) {
  for (const Mode& mode : modes) {
    Eigen::VectorXd& moves = moves_px_[mode.j];
    if (moves.size() == 0) moves = slopes_of({mode.j});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto row = 2 * Eigen::Index(i);
      points[i] = points[i] + sign * mode.waves * Vec2{moves[row], moves[row + 1]};
    }
  }
}

Result<PlanBuilder> PlanBuilder::make(const PlanInputs& inputs) {
  PlanBuilder builder(inputs);
  MeasurementPlan& plan = builder.first_;
  plan.sensor_epoch = inputs.sensor_epoch;
  plan.charge = inputs.sensor.charge;
  plan.tracker_kind = inputs.tracking.tracker;
  plan.spots = {inputs.sensor.charge, lambda_d_px(inputs.optics, inputs.slm, inputs.sensor),
                inputs.lit};
  plan.roi = inputs.roi;
  plan.format = inputs.format;
  if (inputs.reference != nullptr) {
    plan.predicted_px = inputs.reference->positions_px;
    builder.displace(plan.predicted_px, inputs.reference->aberration, -1.0);
    plan.reference_px = known_positions(*inputs.reference);
    plan.reference_introduced_rms_waves = rms_waves(inputs.reference->introduced);
  } else {
    plan.predicted_px = model_spots_px(inputs.lattice, inputs.sensor, inputs.slm, inputs.optics,
                                       inputs.roi.width, inputs.roi.height);
    const Vec2 offset = inputs.beam != nullptr ? inputs.beam->offset_px : Vec2{};
    for (Vec2& at : plan.predicted_px) at = at + offset;
  }
  if (inputs.beam != nullptr) plan.beam = inputs.beam->name;
  plan.region = inputs.region;
  auto tracker = make_tracker(inputs.tracking, plan.spots);
  if (!tracker) return fail(tracker.error());
  plan.tracker = std::move(*tracker);
  auto kinds = SpotKinds::make(inputs.tracking, plan.spots, charges_of(inputs.lattice));
  if (!kinds) return fail(kinds.error());
  plan.kinds = std::move(*kinds);
  const ModeOperator modes = limited(
      inputs.mode_operator != nullptr ? *inputs.mode_operator
                                      : slope_operator(builder.lattice_, builder.sensor_,
                                                       builder.tilt_radii_, builder.px_per_cycle_),
      inputs.tracking.mode_count);
  plan.mode_operator = modes.kind;
  plan.modes_j = measured_modes(inputs.tracking, modes);
  plan.can_fit_shapes = modes.kind != OperatorKind::measured || modes.shapes;
  // A calibration with shapes measures displacements of whole spots. They differ from the tracker's
  // positions, so the model's slopes are used.
  plan.reconstructor = std::make_shared<const Reconstructor>(
      modes.shapes ? builder.slopes_of(modes.modes_j) : modes.slopes, modes.modes_j,
      plan.reference_px,
      rotation_column(inputs.lattice, inputs.sensor, builder.px_per_cycle_, inputs.reference));
  plan.branch_points = std::make_shared<const BranchPoints>(
      builder.lattice_, 0.5 * builder.sensor_.pupil_diameter_px, builder.px_per_cycle_);
  return builder;
}

std::unique_ptr<MeasurementPlan> PlanBuilder::plan(std::uint64_t id, std::uint64_t hologram_id,
                                                   const std::vector<Mode>& aberration,
                                                   std::vector<Mode> correction) {
  auto plan = std::make_unique<MeasurementPlan>(first_);
  plan->id = id;
  plan->hologram_id = hologram_id;
  plan->correction = std::move(correction);
  displace(plan->predicted_px, aberration, 1.0);
  return plan;
}

}  // namespace ovws
