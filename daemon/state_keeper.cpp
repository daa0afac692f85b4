#include "daemon/state_keeper.hpp"

namespace ovws {

void StateKeeper::take(DaemonEvent event) {
  DaemonState before{};
  DaemonState now{};
  {
    const std::lock_guard lock(mutex_);
    before = state_of(conditions_);
    conditions_ = after(conditions_, event);
    now = state_of(conditions_);
  }
  if (now == before) return;
  const std::string name(state_name(now));
  events_.emit("state", Severity::info, "state is " + name,
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

}  // namespace ovws
