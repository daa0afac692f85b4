/// Leases: who changes which part of the bench now, and the daemon's state that follows from it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/lease/request_table.hpp"
#include "proto/daemon_state.hpp"

namespace ovws {

class Lease;
using LeasePtr = std::shared_ptr<Lease>;  ///< null: of a request that changes no part

/// The one place that decides whether a request may be carried out. Keeps what determines the
/// daemon's state, and emits an event for each change of state. Thread-safe.
class Leases {
 public:
  /// Called at each turn of the sensor: `holder` has it from now on, and when the owner of the
  /// sensor has taken notice, it calls `then` (may be empty) in its thread. Called with the lock of
  /// Leases, so in the order of the turns; it must not block, nor call Leases.
  using Turn = std::function<void(Holder holder, std::function<void()> then)>;

  /// `fixed`: the sensor is a fixed array of lenslets, which shows no holograms.
  Leases(Events& events, bool fixed) : events_(events), fixed_(fixed) {}
  ~Leases();
  Leases(const Leases&) = delete;
  Leases& operator=(const Leases&) = delete;

  /// Sets the owner of the sensor; before the first lease.
  void on_turn(Turn turn) { turn_ = std::move(turn); }
  /// Sets a condition of the daemon, from which its state is derived.
  void set(bool Conditions::*condition, bool holds);
  /// Sets in one change whether `device`, whose condition is `condition`, is connected, and its
  /// fault: it is present, but unusable until a person fixes `cause`. Empty: no fault.
  void set_device(const std::string& device, bool Conditions::*condition, bool connected,
                  const std::string& cause);
  /// The daemon's state, and the text of all faults, each with its device; none: no fault.
  struct Report {
    DaemonState state = DaemonState::starting;
    std::optional<std::string> fault;
  };
  Report report() const;
  /// The lease that `request` needs. Nobody else can lease the parts of a holder's lease until it
  /// ends; leases of clients do not exclude each other, and a holder waits for them (Lease::begin).
  /// Errors: what request_table.hpp says of its needs, and of the holder that has one of its parts.
  Result<LeasePtr> take(Request request);
  /// Whether camera and display are connected.
  bool has_bench() const;

 private:
  friend class Lease;
  struct Entry {
    std::uint64_t id = 0;
    Request request = Request::read;
    bool begun = false;
    std::shared_ptr<std::function<void()>> waiting{};  ///< what begins with it; null: nothing yet
  };
  void begin(std::uint64_t id, std::function<void()> then);
  void end(std::uint64_t id);
  bool is_alone(const Entry& entry) const;
  void start(Entry& entry);
  Holder sensors_holder() const;
  DaemonState state() const;
  void publish(DaemonState before);

  Events& events_;
  const bool fixed_;
  Turn turn_ = [](Holder, const std::function<void()>&) {};
  mutable std::mutex mutex_;
  Conditions conditions_;
  std::map<std::string, std::string> causes_;  ///< causes of the faults, by device
  std::vector<Entry> entries_;
  std::uint64_t last_id_ = 0;
};

/// Leave to change parts of the bench. It ends with `end`, or when it is destroyed.
class Lease {
 public:
  Lease(Leases& of, std::uint64_t id, part::Set parts) : of_(of), id_(id), parts_(parts) {}
  ~Lease() { end(); }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;

  /// Calls `then` once, in the thread of the sensor's owner (see Leases::Turn), when all clients'
  /// changes of the same parts have ended that were permitted before. Then the holder has them.
  /// Not called if the lease ends before, and never for a client's lease.
  void begin(std::function<void()> then) { of_.begin(id_, std::move(then)); }
  /// Ends the lease. A second call does nothing. Thread-safe.
  void end() { of_.end(id_); }
  bool has_sensor() const { return (parts_ & part::kSensor) != part::kNone; }

 private:
  Leases& of_;
  const std::uint64_t id_;
  const part::Set parts_;
};

}  // namespace ovws
