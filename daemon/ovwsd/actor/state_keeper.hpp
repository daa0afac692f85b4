/// The daemon's state: hears what came and went, and says what may be done now.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/result.hpp"
#include "core/control/state_machine.hpp"
#include "daemon/ovwsd/actor/events.hpp"

namespace ovws {

/// Thread-safe. Each change of state is an event.
class StateKeeper {
 public:
  explicit StateKeeper(Events& events) : events_(events) {}

  void take(DaemonEvent event);
  /// `device` is there and cannot be used until somebody mends `cause`; an empty cause: no longer.
  void set_fault(const std::string& device, const std::string& cause);
  /// Every cause, with its device; none if there is no fault.
  std::optional<std::string> fault() const;
  /// See `permit`.
  Result<void> check(Action action) const;
  std::string name() const;

 private:
  void move(DaemonEvent event);

  Events& events_;
  mutable std::mutex mutex_;
  Conditions conditions_;
  std::map<std::string, std::string> causes_;  ///< of faults, by device
};

}  // namespace ovws
