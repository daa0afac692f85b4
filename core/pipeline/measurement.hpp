/// A plan together with the memory that measuring with it takes, made off the frame path.
#pragma once

#include <cstdint>
#include <vector>

#include "core/pipeline/neighbourhood.hpp"
#include "core/pipeline/plan.hpp"
#include "core/tracking/acquisition.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {

/// The plan is only read; the rest is working memory, each part for one thread at a time.
struct Measurement {
  /// `workers`: how many threads track at once, at least 1. Throws std::logic_error on a plan that
  /// is not whole.
  Measurement(const MeasurementPlan& measured_plan, int workers);

  const MeasurementPlan& plan;  ///< may be gone before this object is: then only plan_id is left
  const std::uint64_t plan_id;
  std::vector<TrackScratch> track_scratch;  ///< one a worker; [0] also for what follows the workers
  Acquisition acquisition;
  Neighbourhood neighbourhood;
  Reconstructor::Scratch reconstruct_scratch;
};

}  // namespace ovws
