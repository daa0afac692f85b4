#include "daemon/ovwsd/sensor/plans.hpp"

#include "daemon/ovwsd/sensor/beams.hpp"

namespace ovws {
namespace {

bool fits(const FrameFit& fit, const SensorState& state, const MeasurementPlan& plan) {
  return fit.modes_j() == plan.modes_j && fit.point().estimates == state.tracking.estimates;
}

/// Gives the plan the templates if they fit. Otherwise a plan that wants templates waits for them,
/// unless the search for them has been given up.
void use(const ActiveTemplates& templates, const SensorState& state, const Bound& bound,
         MeasurementPlan& plan) {
  if (!plan.may_use_templates() || !takes_templates(state)) return;
  const bool same = templates.made_for == templates_key(state, bound);
  if (same && templates.fit && fits(*templates.fit, state, plan)) plan.fit = templates.fit;
  plan.awaits_templates = plan.wants_templates() && !plan.fit && !(same && templates.given_up);
}

std::vector<std::int64_t> taken_times(const Reference* reference) {
  std::vector<std::int64_t> times;
  if (reference == nullptr) return times;
  for (const BeamReference& beam : reference->beams) times.push_back(beam.t_taken_ns);
  return times;
}

/// The builder of a further source: like `main`, by spot positions alone.
Result<PlanBuilder> beam_builder(const PlanInputs& main, const BeamConfig& beam, Disc region,
                                 const std::vector<Vec2>& model_px) {
  const auto reference =
      main.reference != nullptr ? reference_of(*main.reference, beam, model_px) : std::nullopt;
  const bool shapes = main.mode_operator != nullptr && main.mode_operator->shapes;
  return PlanBuilder::make({{main.lattice, main.sensor, by_positions(main.tracking), main.optics,
                             main.slm, main.roi, main.format},
                            main.sensor_epoch,
                            main.lit,
                            reference ? &*reference : nullptr,
                            shapes ? nullptr : main.mode_operator,
                            &beam,
                            region});
}

}  // namespace

/// Makes the builders, unless the sensor has not changed since the last plan.
Result<void> Plans::make_builders(const SensorState& state, const Bound& bound) {
  const OpticsConfig optics = optics_of(state, bench_);
  const TrackingSettings tracking = tracking_in_use(state);
  const Reference* const reference = bound.reference.get();
  Sensor sensor{state.sensor_epoch,
                state.renderer,
                tracking,
                px_per_cycle(optics, bench_.slm),
                optics.centre_px,
                state.roi,
                state.format,
                reference != nullptr && reference->source == ReferenceSource::model,
                reference != nullptr ? reference->t_taken_ns : 0,
                taken_times(reference),
                bound.mode_operator};
  if (!builders_.empty() && sensor == sensor_) return {};
  builders_.clear();
  const std::vector<Vec2> model_px = model_positions(state, bench_);
  const std::vector<Disc> regions = search_regions(model_px, bench_.beams);
  PlanInputs inputs{{state.renderer->lattice(), state.sensor, tracking, optics, bench_.slm,
                     state.roi, state.format},
                    state.sensor_epoch,
                    lit_pixels(state.format, bench_.optics.wavelength_nm),
                    reference,
                    bound.mode_operator.get()};
  if (!regions.empty()) inputs.region = regions.front();
  auto made = PlanBuilder::make(inputs);
  if (!made) return fail(made.error());
  std::vector<PlanBuilder> builders;
  builders.push_back(std::move(*made));
  for (std::size_t k = 0; k < bench_.beams.size(); ++k) {
    auto beam = beam_builder(inputs, bench_.beams[k], regions[k + 1], model_px);
    if (!beam) return fail(beam.error());
    builders.push_back(std::move(*beam));
  }
  builders_ = std::move(builders);
  sensor_ = std::move(sensor);
  return {};
}

Result<std::unique_ptr<MeasurementPlan>> Plans::build(const SensorState& state, const Bound& bound,
                                                      std::uint64_t hologram_id) {
  if (auto made = make_builders(state, bound); !made) return fail(made.error());
  const std::uint64_t id = next_id_++;
  const auto plan_of = [&](PlanBuilder& builder) {
    return builder.plan(id, hologram_id, shown_modes(state), state.correction);
  };
  auto plan = plan_of(builders_.front());
  if (shows_sequence(state)) {
    add_patterns(state, *plan);
    return plan;
  }
  ovws::use(state.templates, state, bound, *plan);
  for (std::size_t k = 1; k < builders_.size(); ++k) plan->beams.push_back(plan_of(builders_[k]));
  return plan;
}

void Plans::add_patterns(const SensorState& state, MeasurementPlan& plan) {
  plan.cycle = state.cycle;
  plan.can_fit_shapes = false;
  for (std::size_t k = 0; k < state.sequence.size(); ++k) {
    auto pattern = builders_.front().plan(plan.id, plan.hologram_id, pattern_modes(state, k),
                                          state.correction);
    pattern->can_fit_shapes = false;
    plan.patterns.push_back(std::move(pattern));
  }
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
