/// Builds and numbers measurement plans, and frees a plan when no frame uses it any more.
#pragma once

#include <cstdint>
#include <list>
#include <memory>

#include "core/pipeline/pipeline.hpp"
#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// All measurement plans of the daemon, the active one and superseded ones. Not thread-safe.
class Plans {
 public:
  Plans(Pipeline& pipeline, BenchOptics bench) : pipeline_(pipeline), bench_(std::move(bench)) {}

  /// Builds the plan for a state and a hologram. Errors: those of make_tracker.
  Result<std::unique_ptr<MeasurementPlan>> build(const SensorState& state, const Bound& bound,
                                                 std::uint64_t hologram_id);
  /// Activates the plan at the next frame edge.
  void use(std::unique_ptr<MeasurementPlan> plan);
  /// Frees superseded plans that no frame record refers to.
  void retire();

 private:
  Pipeline& pipeline_;
  BenchOptics bench_;
  std::uint64_t next_id_ = 1;
  std::list<std::unique_ptr<MeasurementPlan>> plans_;  ///< oldest first; the last is active
};

}  // namespace ovws
