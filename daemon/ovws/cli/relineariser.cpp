#include "daemon/ovws/cli/relineariser.hpp"

#include "core/wavefront/diffractive_matrix.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"

namespace ovws::cli {
namespace {

constexpr int kSteps = 3;         // each reduces the error about tenfold
constexpr double kAtRest = 0.02;  // waves; largest last step of a converged fit

}  // namespace

Result<Relineariser> Relineariser::make(const Config& config, const MeasurementPlan& plan,
                                        bool measured) {
  auto model = SensorModel::make(config.sensor, config.slm.geometry, config.optics, plan.roi.width,
                                 plan.roi.height);
  if (!model) return fail(model.error());
  auto tracker = make_tracker(config.tracking, plan.spots);
  if (!tracker) return fail(tracker.error());
  Relineariser made(std::move(*model), std::move(*tracker));
  made.sensor_ = config.sensor;
  made.slopes_ = slope_operator(made.model_.lattice(), config.sensor, config.tracking,
                                made.model_.px_per_cycle());
  made.to_model_px_.assign(plan.reference_px.size(), Vec2{});
  if (!measured) return made;
  const auto flat = model_fixes(made.model_, config.sensor, *made.tracker_, {});
  if (!flat) return fail(flat.error());
  for (std::size_t i = 0; i < flat->size(); ++i) {
    made.to_model_px_[i] = Vec2{double((*flat)[i].x), double((*flat)[i].y)} - plan.reference_px[i];
  }
  return made;
}

Result<Relinearised> Relineariser::measure(const std::vector<SpotFix>& spots,
                                           const std::vector<int>& split,
                                           const std::vector<float>& linear) {
  std::vector<SpotFix> fixes = spots;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    fixes[i].x += float(to_model_px_[i].x);
    fixes[i].y += float(to_model_px_[i].y);
  }
  for (const int i : split) fixes[std::size_t(i)] = {};
  auto found = relinearise(model_, sensor_, *tracker_, slopes_.slopes, slopes_.modes_j, fixes,
                           linear, kSteps);
  if (found && found->last_step_waves > kAtRest) {
    return fail(Errc::refused, "operator",
                "the steps of the relinearised operator do not converge");
  }
  return found;
}

}  // namespace ovws::cli
