/// The daemon's state machine: takes the conditions of devices and jobs, and decides which actions
/// are allowed.
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

  /// Sets one of the conditions that determine the state.
  void set(bool Conditions::*condition, bool holds);
  /// Sets the fault of `device`, which is present and cannot be used until a person fixes `cause`.
  /// An empty cause clears it.
  void set_fault(const std::string& device, const std::string& cause);
  /// All faults, each with its device; none if there is no fault.
  std::optional<std::string> fault() const;
  /// Whether the present state allows `action`; see `permit`.
  Result<void> check(Action action) const;
  std::string name() const;

 private:
  void set_locked(bool Conditions::*condition, bool holds);

  Events& events_;
  mutable std::mutex mutex_;
  Conditions conditions_;
  std::map<std::string, std::string> causes_;  ///< of the faults, by device
};

}  // namespace ovws
