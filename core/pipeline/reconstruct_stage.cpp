/// Calls the plan's reconstructor on the frame's spots.
#include "core/pipeline/reconstruct_stage.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/pipeline/frame_rules.hpp"
#include "core/pipeline/measurement.hpp"
#include "core/port/clock.hpp"

namespace ovws {

void ReconstructStage::run(Entry& entry) OVWS_NONBLOCKING {
  const MeasurementPlan& plan = *entry.plan;
  entry.mode_count = int(plan.modes_j.size());
  const std::span<SpotFix> spots{entry.spots.data(), std::size_t(entry.spot_count)};
  if (entry.templates.credible) {
    const std::size_t modes = plan.modes_j.size();
    entry.reconstruction =
        reconstruction_of(entry.templates, plan.modes_j, {entry.coefficients.data(), modes});
  } else {
    std::fill_n(entry.coefficients.begin(), entry.mode_count, NAN);
    std::fill_n(entry.sigma_waves.begin(), entry.mode_count, NAN);
    entry.reconstruction = plan.reconstructor->solve_without_outliers(
        spots, entry.measurement->reconstruct_scratch,
        std::span<float>{entry.coefficients.data(), plan.reconstructor->modes_j().size()},
        kCredibleResidual * plan.spots.lambda_d_px);
  }
  entry.tracked = int(
      std::count_if(spots.begin(), spots.end(), [](const SpotFix& spot) { return spot.found(); }));
  const bool measured = entry.settled && entry.reconstruction.determined && plan.referenced();
  const bool by_positions =
      measured && is_explained(entry.reconstruction, spots, plan.spots.lambda_d_px);
  const bool by_templates = plan.fit != nullptr || plan.awaits_templates;
  const bool suffices = plan.positions_suffice() && (!by_templates || entry.follows);
  entry.unconfirmed = by_positions && !entry.templates.credible && !suffices;
  entry.explained = !measured || entry.templates.credible || (by_positions && !entry.unconfirmed);
  entry.valid = measured && entry.explained;
  entry.t_reconstructed_mono_ns = monotonic_ns();
  deps_.latency.record(entry.t_reconstructed_mono_ns - entry.frame.t_arrival_mono_ns);
  deps_.outbox.put(entry);
}

}  // namespace ovws
