/// The daemon's state: hears what came and went, and says what may be done now.
#pragma once

#include <mutex>
#include <string>

#include "core/base/result.hpp"
#include "core/control/state_machine.hpp"
#include "daemon/events.hpp"

namespace ovws {

/// Thread-safe. Each change of state is an event.
class StateKeeper {
 public:
  explicit StateKeeper(Events& events) : events_(events) {}

  void take(DaemonEvent event);
  /// See `permit`.
  Result<void> check(Action action) const;
  std::string name() const;

 private:
  Events& events_;
  mutable std::mutex mutex_;
  Conditions conditions_;
};

}  // namespace ovws
