#include "daemon/ovwsd/sensor/branch_check.hpp"

#include <spdlog/fmt/fmt.h>

#include <memory>
#include <vector>

#include "core/pipeline/position_modes.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {

std::string branch_point_text(int count, const BranchPoint& first) {
  return fmt::format("{} (phase singularity) near x {:+.2f}, y {:+.2f} pupil radii, charge {:+}",
                     count == 1 ? std::string("a branch point")
                                : fmt::format("{} branch points, the first", count),
                     first.at.x, first.at.y, first.charge);
}

Result<void> check_branch_points(const SpotAverage& average, const SensorState& state,
                                 const BenchOptics& optics) {
  const Lattice& lattice = state.renderer->lattice();
  const PxPerCycle map = px_per_cycle(optics_of(state, optics), optics.slm);
  const ModeOperator modes = slope_operator(lattice, state.sensor, state.tracking, map);
  Reference of_model;
  of_model.source = ReferenceSource::model;
  MeasurementPlan plan;
  plan.spots.lambda_d_px = lambda_d_of(state, optics);
  plan.reconstructor = std::make_shared<const Reconstructor>(
      modes.slopes, modes.modes_j, model_positions(state, optics),
      rotation_column(lattice, state.sensor, map, &of_model));
  plan.branch_points =
      std::make_shared<const BranchPoints>(lattice, 0.5 * state.sensor.pupil_diameter_px, map);
  std::vector<SpotFix> spots;
  for (const Vec2 at : found_positions(average)) spots.push_back({float(at.x), float(at.y)});
  auto scratch = plan.reconstructor->make_scratch();
  std::vector<Vec2> left_px(spots.size());
  std::vector<float> coefficients(modes.modes_j.size());
  FoundBranchPoints found;
  reconstruct_positions(plan, spots, scratch, left_px, coefficients, found);
  if (found.count == 0) return {};
  return fail(
      Errc::refused, "",
      fmt::format("the light has {}: a reference would hide it. Remove what makes the phase "
                  "jump, such as a vortex plate, a scatterer or turbulent air, and take the "
                  "reference again{}",
                  branch_point_text(found.count, found.points.front()),
                  optics_of(state, optics).registered
                      ? ""
                      : ". A turned camera displaces the spots in the same way: if it may be "
                        "turned, run registration.run first"));
}

}  // namespace ovws
