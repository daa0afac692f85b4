#include "core/pipeline/position_modes.hpp"

#include <cmath>

#include "core/pipeline/frame_rules.hpp"

namespace ovws {
namespace {

/// The only spot that was known and has been rejected; -1 if there is none, or several.
int only_outlier(std::span<const SpotFix> spots, std::span<const Vec2> left_px) {
  int outlier = -1;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (spots[i].found() || std::isnan(left_px[i].x)) continue;
    if (outlier >= 0) return -1;
    outlier = int(i);
  }
  return outlier;
}

}  // namespace

Reconstruction reconstruct_positions(const MeasurementPlan& plan, std::span<SpotFix> spots,
                                     Reconstructor::Scratch& scratch, std::span<Vec2> left_px,
                                     std::span<float> coefficients,
                                     FoundBranchPoints& found) OVWS_NONBLOCKING {
  const Reconstructor& positions = *plan.reconstructor;
  const std::span<float> leading = coefficients.first(positions.modes_j().size());
  found.count = 0;
  const Reconstruction all = positions.solve(spots, scratch, leading);
  const bool looks = plan.branch_points != nullptr && all.determined && !too_many_lost(all);
  if (looks) positions.residuals(spots, scratch, left_px);
  const double acceptable_px = kCredibleResidual * plan.spots.lambda_d_px;
  // Without outliers a second solution would be the same.
  const Reconstruction rest =
      all.determined && all.fit_residual_px <= acceptable_px
          ? all
          : positions.solve_without_outliers(spots, scratch, leading, acceptable_px);
  if (looks) {
    found.count = plan.branch_points->find(left_px, only_outlier(spots, left_px), found.points);
  }
  return rest;
}

}  // namespace ovws
