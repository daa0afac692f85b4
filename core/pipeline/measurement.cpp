/// Validates a plan and allocates its working memory.
#include "core/pipeline/measurement.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/optics/lattice.hpp"
#include "core/pipeline/frame_record.hpp"

namespace ovws {
namespace {

const MeasurementPlan& checked(const MeasurementPlan& plan) {
  const auto demand = [](bool holds, const char* what) {
    if (!holds) throw std::logic_error(what);
  };
  demand(plan.tracker != nullptr, "measurement plan without a tracker");
  demand(!plan.kinds || int(plan.kinds->of_spots().size()) == plan.subapertures(),
         "measurement plan with kinds of other spots");
  demand(plan.reconstructor != nullptr, "measurement plan without a reconstructor");
  demand(plan.subapertures() <= kMaxSubapertures, "measurement plan with too many subapertures");
  const std::vector<int>& leading = plan.reconstructor->modes_j();
  demand(leading.size() <= plan.modes_j.size() &&
             std::equal(leading.begin(), leading.end(), plan.modes_j.begin()),
         "measurement plan whose positions determine other modes");
  demand(!plan.fit || plan.fit->modes_j() == plan.modes_j,
         "measurement plan whose templates have other modes");
  demand(plan.beams.size() <= std::size_t(kMaxBeams), "measurement plan with too many beams");
  demand(plan.beam.empty() || (!plan.fit && plan.beams.empty()),
         "measurement plan of a beam with templates or beams");
  demand(plan.patterns.size() < std::size_t(kMaxPatternSlots),
         "measurement plan with too many patterns");
  demand(plan.patterns.empty() || plan.beams.empty(), "measurement plan with patterns and beams");
  demand(
      plan.patterns.empty() || (plan.cycle.slots > int(plan.patterns.size()) &&
                                plan.cycle.slots <= kMaxPatternSlots && plan.cycle.period_ns > 0),
      "measurement plan with patterns and no cycle for them");
  demand(std::ranges::all_of(plan.patterns,
                             [](const auto& one) { return !one->fit && one->patterns.empty(); }),
         "measurement plan of a pattern with templates or patterns");
  demand(plan.modes_j.size() <= std::size_t(kMaxModes), "measurement plan with too many modes");
  return plan;
}

}  // namespace

Measurement::Measurement(const MeasurementPlan& measured_plan, int workers,
                         const Measurement* before)
    : plan(checked(measured_plan)),
      plan_id(plan.id),
      acquisition(plan.spots, plan.predicted_px, plan.roi.width, plan.roi.height,
                  before != nullptr ? &before->acquisition : nullptr, plan.region, plan.kinds),
      neighbourhood(plan.predicted_px),
      reconstruct_scratch(plan.reconstructor->make_scratch()),
      left_px(std::size_t(plan.subapertures())) {
  for (int k = 0; k < std::max(workers, 1); ++k) {
    track_scratch.push_back(plan.make_scratch());
    if (plan.fit) fit_scratch.push_back(plan.fit->spots().make_scratch());
  }
  if (plan.fit) solve_scratch = plan.fit->make_scratch();
  for (const auto& beam : plan.beams) {
    beams.push_back(std::make_unique<Measurement>(*beam, workers, this));
  }
  for (const auto& pattern : plan.patterns) {
    patterns.push_back(std::make_unique<Measurement>(*pattern, workers, this));
  }
}

}  // namespace ovws
