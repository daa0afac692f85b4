/// Modes and branch points of one frame from the positions of its spots.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/pipeline/plan.hpp"

namespace ovws {

struct FoundBranchPoints {
  std::array<BranchPoint, kMaxBranchPoints> points{};  ///< the first `count` are in use
  int count = 0;
};

/// Reconstructs the modes from `spots` (Reconstructor::solve_without_outliers) and writes their
/// coefficients. Also looks for branch points, unless more than a sixth of the spots is lost. Spots
/// near a branch point may be outliers, so it is looked for in the fit to all spots. `left_px`:
/// working memory, one element per spot. RT-safe.
Reconstruction reconstruct_positions(const MeasurementPlan& plan, std::span<SpotFix> spots,
                                     Reconstructor::Scratch& scratch, std::span<Vec2> left_px,
                                     std::span<float> coefficients,
                                     FoundBranchPoints& found) OVWS_NONBLOCKING;

}  // namespace ovws
