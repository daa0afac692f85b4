/// Measurement plans: built for a state of the sensor, numbered, and retired when no frame is on
/// its way with them.
#pragma once

#include <cstdint>
#include <list>
#include <memory>

#include "core/pipeline/pipeline.hpp"
#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/reference_templates.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// One thread at a time.
class Plans {
 public:
  /// `workers`: threads that track.
  Plans(Pipeline& pipeline, BenchOptics bench, int workers)
      : pipeline_(pipeline), bench_(std::move(bench)), workers_(workers) {}

  /// Errors as of make_tracker.
  Result<std::unique_ptr<MeasurementPlan>> build(const SensorState& state, const Bound& bound,
                                                 std::uint64_t hologram_id);
  /// Frames that come from now on are measured with it.
  void use(std::unique_ptr<MeasurementPlan> plan);
  /// Frees those that no frame needs any more.
  void retire();
  /// Which spots have templates of their own in such a plan.
  TemplateReport templates(const SensorState& state, const Bound& bound);

 private:
  const OwnTemplates& templates_of(const SensorState& state, const Bound& bound);

  Pipeline& pipeline_;
  BenchOptics bench_;
  int workers_;
  std::uint64_t next_id_ = 1;
  TemplateShelf templates_;
  std::list<std::unique_ptr<MeasurementPlan>> plans_;  ///< oldest first; the last is in use
};

}  // namespace ovws
