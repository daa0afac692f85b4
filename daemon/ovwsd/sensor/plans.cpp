#include "daemon/ovwsd/sensor/plans.hpp"

namespace ovws {
namespace {

/// Time (UTC) at which the calibration that gives measured templates was taken; 0: none does.
std::int64_t active_shapes_ns(const Bound& bound) {
  const bool shapes = bound.mode_operator && bound.mode_operator->shapes && bound.calibration;
  return shapes ? bound.calibration->t_taken_ns : 0;
}

/// Whether the templates were made for this sensor epoch, reference and calibration.
bool are_of(const ActiveTemplates& templates, const SensorState& state, const Bound& bound) {
  return templates.sensor_epoch == state.sensor_epoch &&
         templates.reference_taken_ns == bound.reference->t_taken_ns &&
         templates.calibration_taken_ns == active_shapes_ns(bound);
}

bool fits(const FrameFit& fit, const SensorState& state, const MeasurementPlan& plan) {
  return fit.modes_j() == plan.modes_j && fit.point().estimates == state.tracking.estimates;
}

/// Gives the plan the templates if they fit. Otherwise a plan that wants templates waits for them,
/// unless the search for them has been given up.
void use(const ActiveTemplates& templates, const SensorState& state, const Bound& bound,
         MeasurementPlan& plan) {
  if (!plan.may_use_templates() || !takes_templates(state)) return;
  const bool same = are_of(templates, state, bound);
  if (same && templates.fit && fits(*templates.fit, state, plan)) plan.fit = templates.fit;
  plan.awaits_templates = plan.wants_templates() && !plan.fit && !(same && templates.given_up);
}

}  // namespace

/// The last plan's builder, unless the sensor has changed.
Result<PlanBuilder*> Plans::builder_for(const SensorState& state, const Bound& bound) {
  const OpticsConfig optics = optics_of(state, bench_);
  const Reference* const reference = bound.reference.get();
  Sensor sensor{state.sensor_epoch,
                state.renderer,
                state.tracking,
                px_per_cycle(optics, bench_.slm),
                optics.centre_px,
                state.roi,
                state.format,
                reference != nullptr && reference->source == ReferenceSource::model,
                reference != nullptr ? reference->t_taken_ns : 0,
                bound.mode_operator};
  if (builder_ && sensor == sensor_) return &*builder_;
  builder_.reset();
  auto made = PlanBuilder::make({state.sensor_epoch, state.renderer->lattice(), state.sensor,
                                 state.tracking, optics, bench_.slm, state.roi, state.format,
                                 lit_pixels(state.format, bench_.optics.wavelength_nm), reference,
                                 bound.mode_operator.get()});
  if (!made) return fail(made.error());
  builder_.emplace(std::move(*made));
  sensor_ = std::move(sensor);
  return &*builder_;
}

Result<std::unique_ptr<MeasurementPlan>> Plans::build(const SensorState& state, const Bound& bound,
                                                      std::uint64_t hologram_id) {
  auto builder = builder_for(state, bound);
  if (!builder) return fail(builder.error());
  auto plan = (*builder)->plan(next_id_++, hologram_id, shown_modes(state), state.correction);
  ovws::use(state.templates, state, bound, *plan);
  return plan;
}

void Plans::use(std::unique_ptr<MeasurementPlan> plan) {
  pipeline_.use_plan(plan.get());
  plans_.push_back(std::move(plan));
}

void Plans::retire() {
  const std::uint64_t oldest = pipeline_.oldest_plan_in_use();
  while (plans_.size() > 1 && plans_.front()->id < oldest) plans_.pop_front();
}

}  // namespace ovws
