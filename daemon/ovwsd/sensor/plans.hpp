/// Builds and numbers measurement plans, and frees a plan when no frame uses it any more.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <vector>

#include "core/pipeline/pipeline.hpp"
#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
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
  /// What all plans of one builder have in common.
  struct Sensor {
    std::uint64_t epoch = 0;
    std::shared_ptr<const HologramRenderer> renderer;  ///< of one sensor on one SLM
    TrackingSettings tracking;
    PxPerCycle px_per_cycle;
    std::optional<Vec2> centre_px;  ///< OpticsConfig::centre_px
    Roi roi;
    PixelFormat format = PixelFormat::mono8;
    bool by_model = false;                ///< model reference: its positions follow from the above
    std::int64_t reference_taken_ns = 0;  ///< UTC; 0: no reference
    std::vector<std::int64_t> beams_taken_ns;  ///< of each reference of a further source
    std::shared_ptr<const ModeOperator> mode_operator;
    friend bool operator==(const Sensor&, const Sensor&) = default;
  };
  Result<void> make_builders(const SensorState& state, const Bound& bound);
  void add_patterns(const SensorState& state, MeasurementPlan& plan);

  Pipeline& pipeline_;
  BenchOptics bench_;
  std::uint64_t next_id_ = 1;
  Sensor sensor_;                      ///< of builders_
  std::vector<PlanBuilder> builders_;  ///< of the main source, then of each further one
  std::list<std::unique_ptr<MeasurementPlan>> plans_;  ///< oldest first; the last is active
};

}  // namespace ovws
