#include "daemon/ovwsd/actor/state_keeper.hpp"

namespace ovws {

void StateKeeper::set(bool Conditions::*condition, bool holds) {
  const std::lock_guard lock(mutex_);
  const DaemonState before = state_of(conditions_);
  conditions_.*condition = holds;
  publish(before);
}

void StateKeeper::set_device(const std::string& device, bool Conditions::*condition, bool connected,
                             const std::string& cause) {
  const std::lock_guard lock(mutex_);
  const DaemonState before = state_of(conditions_);
  conditions_.*condition = connected;
  if (cause.empty()) {
    causes_.erase(device);
  } else {
    causes_[device] = cause;
  }
  conditions_.fault = !causes_.empty();
  publish(before);
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

/// Emits an event if the state is not `before` any more. Call with mutex_ locked, so that events of
/// different threads keep their order.
void StateKeeper::publish(DaemonState before) {
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
