/// A measurement plan with its preallocated working memory, made off the frame path.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/pipeline/neighbourhood.hpp"
#include "core/pipeline/plan.hpp"
#include "core/tracking/acquisition.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {

/// Measurement plan (read-only) and its working memory, each part for one thread at a time. Frames
/// are searched for spots in their order, so that measurements can share the memory for that.
struct Measurement {
  /// `workers`: number of tracker threads; values below 1 count as 1. `before`: the measurement of
  /// the plan before, for Acquisition; null: none. Throws std::logic_error on an incomplete plan.
  Measurement(const MeasurementPlan& measured_plan, int workers,
              const Measurement* before = nullptr);

  const MeasurementPlan& plan;  ///< may be destroyed before this object: then only plan_id is valid
  const std::uint64_t plan_id;
  std::vector<TrackScratch> track_scratch;  ///< one per worker; [0] also after the workers
  Acquisition acquisition;
  Neighbourhood neighbourhood;
  Reconstructor::Scratch reconstruct_scratch;
  std::vector<Vec2> left_px;  ///< per spot: displacement that the modes do not explain
  std::vector<SpotFit::Scratch> fit_scratch;  ///< one per worker; empty without plan.fit
  FrameFit::Scratch solve_scratch;
  std::vector<std::unique_ptr<Measurement>> beams;     ///< in the order of plan.beams
  std::vector<std::unique_ptr<Measurement>> patterns;  ///< in the order of plan.patterns
};

}  // namespace ovws
