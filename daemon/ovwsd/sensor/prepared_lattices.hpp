/// Prepared lattices: sensors that lattice.prepare has measured and lattice.use switches to.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "core/base/result.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/sensor/sensor_edit.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"
#include "proto/tables/lattices.hpp"

namespace ovws {

/// Settings and exposure of each prepared lattice, by name: one state file each, of kind `lattice`.
/// References and calibrations are not here: those of the same settings apply (Knowledge).
/// Thread-safe.
class PreparedLattices {
 public:
  using All = std::map<std::string, PreparedLattice>;

  PreparedLattices(DaemonStore& store, Events& events) : store_(store), events_(events) {}

  /// Reads all files; blocks on the disk. An event reports each that is not a lattice.
  void load();
  All all() const;
  /// Errc::invalid, field "name": there is none of this name.
  Result<PreparedLattice> find(const std::string& name) const;
  /// Adds or replaces a lattice. An event reports its file, or why it cannot be written.
  void keep(const PreparedLattice& lattice);
  /// Deletes a lattice; `done` is called in the disk thread. Errors: those of find and of the disk.
  void remove(const std::string& name, std::function<void(Result<void>)> done);

 private:
  DaemonStore& store_;
  Events& events_;
  mutable std::mutex mutex_;
  All all_;
};

/// Makes a prepared lattice the sensor in use; aberration and correction stay. Errors: those of
/// set_unchecked_sensor, check_sampling and check_beams; Errc::refused, field "name": no reference
/// applies to it.
SensorChange use_lattice(const PreparedLattice& lattice);
/// Whether the lattice is in use, and could be used now. Prepare thread.
LatticeReport report_of(const PreparedLattice& lattice, const SensorEdit& now);
/// Checks a lattice before it is prepared. Errors: those of set_sensor and of the lattice's
/// hologram and spots; Errc::refused, field "sensor.operator": `measured` without a calibration.
/// Prepare thread.
Result<void> check_request(const LatticeRequest& request, bool calibrate, const SensorEdit& now);

}  // namespace ovws
