/// Frees a plan's memory once the adopted plan and the plans of all records in use are newer.
#include "core/pipeline/plan_exchange.hpp"

#include <algorithm>
#include <stdexcept>

namespace ovws {

void PlanExchange::offer(const MeasurementPlan* plan) {
  const std::lock_guard lock(control_);
  const std::uint64_t oldest = oldest_in_use();
  std::erase_if(measurements_, [&](const auto& m) { return m->plan_id < oldest; });
  if (plan == nullptr) {
    offered_.store(nullptr, std::memory_order_release);
    return;
  }
  if (plan->id < next_id_) throw std::logic_error("the id of a measurement plan must increase");
  const Measurement* const before = measurements_.empty() ? nullptr : measurements_.back().get();
  measurements_.push_back(std::make_unique<Measurement>(*plan, workers_, before));
  next_id_ = plan->id + 1;
  offered_.store(measurements_.back().get(), std::memory_order_release);
}

std::uint64_t PlanExchange::oldest_in_use() const {
  // Read the adopted id before the pool: a record refers to a plan only after its adoption.
  const std::uint64_t adopted = adopted_id_.load(std::memory_order_acquire);
  return std::min(adopted, pool_.oldest_plan_id());
}

Measurement* PlanExchange::adopt() OVWS_NONBLOCKING {
  Measurement* const offered = offered_.load(std::memory_order_acquire);
  if (offered == adopted_) return adopted_;
  const std::uint64_t id =
      offered != nullptr ? offered->plan_id : adopted_id_.load(std::memory_order_relaxed) + 1;
  adopted_ = offered;
  adopted_id_.store(id, std::memory_order_release);
  return adopted_;
}

}  // namespace ovws
