#include "drivers/twin/faults.hpp"

namespace ovws::twin {

void Faults::order(const Fault& fault) {
  const std::lock_guard lock(mutex_);
  fault_ = fault;
  until_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                              std::chrono::duration<double>(fault.seconds));
  ++orders_;
  changed_.notify_all();
}

Fault Faults::current() const {
  Fault fault = fault_;
  if (fault.frames == 0) {
    fault.seconds = std::chrono::duration<double>(until_ - Clock::now()).count();
    if (fault.seconds <= 0.0) return {};
  }
  return fault;
}

Fault Faults::active() const {
  const std::lock_guard lock(mutex_);
  return current();
}

bool Faults::unplugged() const {
  return active().kind == FaultKind::unplug;
}

FrameFate Faults::next_frame(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const Fault fault = current();
  if (fault.frames > 0 && --fault_.frames == 0) fault_ = {};
  const std::uint64_t order = orders_;
  const auto until = until_;  // copied: wait_until reads its deadline while the mutex is unlocked
  const auto other_order = [this, order] { return orders_ != order; };
  switch (fault.kind) {
    case FaultKind::drop:
      return FrameFate::drop;
    case FaultKind::incomplete:
      return FrameFate::incomplete;
    case FaultKind::duplicate:
      return FrameFate::duplicate;
    case FaultKind::reorder:
      return FrameFate::reorder;
    case FaultKind::delay:
      changed_.wait_for(lock, stop, std::chrono::duration<double, std::milli>(fault.delay_ms),
                        other_order);
      return FrameFate::send;
    case FaultKind::freeze:
      changed_.wait_until(lock, stop, until, other_order);
      return FrameFate::send;
    case FaultKind::none:
    case FaultKind::unplug:
    case FaultKind::slow_registers:
      return FrameFate::send;
  }
  return FrameFate::send;
}

}  // namespace ovws::twin
