/// Hands measurement plans to the frame path without locks, and reports which are still in use.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/pipeline/measurement.hpp"
#include "core/pipeline/record_pool.hpp"

namespace ovws {

class PlanExchange {
 public:
  PlanExchange(const RecordPool& pool, int workers) : pool_(pool), workers_(workers) {}

  // Control side; thread-safe among each other.
  /// Offers a plan to the frame path: allocates its working memory, and frees that of unused plans.
  /// nullptr: frames are not measured. Throws std::logic_error if the plan's id does not increase.
  void offer(const MeasurementPlan* plan);
  /// Smallest plan id that the frame path or a record may still use.
  std::uint64_t oldest_in_use() const;

  /// Acquisition thread, between two frames: switches to the plan offered last, and returns the
  /// measurement of the plan now in use. nullptr: no plan was offered yet, or nullptr was
  /// offered last.
  Measurement* adopt() OVWS_NONBLOCKING;

 private:
  const RecordPool& pool_;
  const int workers_;
  std::mutex control_;
  std::vector<std::unique_ptr<Measurement>> measurements_;  ///< guarded by control_
  std::uint64_t next_id_ = 0;                               ///< guarded by control_
  std::atomic<Measurement*> offered_{nullptr};
  Measurement* adopted_ = nullptr;  ///< acquisition thread
  /// Smallest plan id that the acquisition thread may still use. Written when a plan is adopted,
  /// before its first use.
  std::atomic<std::uint64_t> adopted_id_{0};
};

}  // namespace ovws
