/// Prepared lattices: sensors that lattice.prepare has measured and lattice.use switches to.
#pragma once

#include "core/base/result.hpp"
#include "daemon/ovwsd/library/named_items.hpp"
#include "daemon/ovwsd/sensor/sensor_edit.hpp"
#include "proto/tables/lattices.hpp"

namespace ovws {

/// Settings and exposure of each prepared lattice. References and calibrations are not here: those
/// of the same settings apply (Knowledge).
struct LatticeItem {
  using Item = PreparedLattice;
  static constexpr const ItemKind& kKind = kLatticeItems;
  static constexpr const char* kMissing =
      "lattice.list lists them, and lattice.prepare prepares one";
  static std::int64_t time(const PreparedLattice& lattice) { return lattice.t_prepared_ns; }
  static Json encode(const PreparedLattice& lattice) { return to_json(lattice); }
  static Result<PreparedLattice> decode(const Json& content) {
    return ovws::decode<PreparedLattice>(content);
  }
  static PreparedLattice in_memory(PreparedLattice lattice) { return lattice; }
};
class PreparedLattices : public NamedItems<LatticeItem> {
 public:
  using NamedItems::NamedItems;
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
