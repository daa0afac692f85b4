/// The daemon's state machine: derives the state from the conditions of devices and jobs, and
/// decides which actions are allowed.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/result.hpp"
#include "core/control/state_machine.hpp"
#include "daemon/ovwsd/actor/events.hpp"

namespace ovws {

/// Keeps the daemon's state and emits an event for each change of state. Thread-safe.
class StateKeeper {
 public:
  explicit StateKeeper(Events& events) : events_(events) {}

  /// Sets a condition of the daemon (camera, display, job, ...), from which the state is derived.
  void set(bool Conditions::*condition, bool holds);
  /// Sets in one change whether `device`, whose condition is `condition`, is connected, and its
  /// fault: it is present, but unusable until a person fixes `cause`. Empty: no fault.
  void set_device(const std::string& device, bool Conditions::*condition, bool connected,
                  const std::string& cause);
  /// Text of all faults, each with its device; none if there is no fault.
  std::optional<std::string> fault() const;
  /// Checks whether the current state allows `action`; see `permit`.
  Result<void> check(Action action) const;
  std::string name() const;
  /// Whether camera and display are connected.
  bool has_bench() const;

 private:
  void publish(DaemonState before);

  Events& events_;
  mutable std::mutex mutex_;
  Conditions conditions_;
  std::map<std::string, std::string> causes_;  ///< causes of the faults, by device
};

}  // namespace ovws
