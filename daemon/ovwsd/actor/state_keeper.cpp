#include "daemon/ovwsd/actor/state_keeper.hpp"

namespace ovws {

void StateKeeper::set(bool Conditions::*condition, bool holds) {
  const std::lock_guard lock(mutex_);
  set_locked(condition, holds);
}

void StateKeeper::set_fault(const std::string& device, const std::string& cause) {
  const std::lock_guard lock(mutex_);
  if (cause.empty()) {
    causes_.erase(device);
  } else {
    causes_[device] = cause;
  }
  set_locked(&Conditions::fault, !causes_.empty());
}

std::optional<std::string> StateKeeper::fault() const {
  const std::lock_guard lock(mutex_);
  if (causes_.empty()) return std::nullopt;
  std::string text;
  for (const auto& [device, cause] : causes_) {
    text += (text.empty() ? "" : "; ") + device + ": " + cause;
  }
  return text;
}

/// Sets a condition and emits an event if the state changes. Call with mutex_ locked, so that
/// events of different threads keep their order.
void StateKeeper::set_locked(bool Conditions::*condition, bool holds) {
  const DaemonState before = state_of(conditions_);
  conditions_.*condition = holds;
  const DaemonState now = state_of(conditions_);
  if (now == before) return;
  const std::string name(state_name(now));
  const auto severity = now == DaemonState::fault ? Severity::error : Severity::info;
  events_.emit("state", severity, "state is " + name,
               {{"state", name}, {"before", state_name(before)}});
}

Result<void> StateKeeper::check(Action action) const {
  const std::lock_guard lock(mutex_);
  return permit(conditions_, action);
}

std::string StateKeeper::name() const {
  const std::lock_guard lock(mutex_);
  return std::string(state_name(state_of(conditions_)));
}

bool StateKeeper::has_bench() const {
  const std::lock_guard lock(mutex_);
  return conditions_.camera && conditions_.display;
}

}  // namespace ovws
