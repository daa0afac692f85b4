#include "daemon/ovwsd/sensor/prepared_lattices.hpp"

#include <utility>

#include "daemon/ovwsd/sensor/sensor_changes.hpp"
#include "proto/field_json.hpp"

namespace ovws {
namespace {

bool is_in_use(const PreparedLattice& lattice, const SensorState& state) {
  return to_json(lattice.settings) == to_json(SensorSettings{state.sensor, state.tracking});
}

/// Refuses a sensor without a reference: none of its frames would be valid. One with a reference
/// was measured on this bench, so that its spots need no other check.
Result<void> check_reference(const SensorEdit& edit) {
  if (bind(edit.state, edit.knowledge, edit.bench.optics).reference) return {};
  const std::string why = missing_reference_reason(edit.state, edit.knowledge, edit.bench.optics);
  return fail(Errc::refused, "name",
              (why.empty() ? "its reference was deleted" : why) +
                  ": prepare it again with lattice.prepare");
}

/// Refuses a lattice of the operator `measured` without its calibration.
Result<void> check_calibration(const SensorEdit& edit) {
  if (edit.state.tracking.mode_operator != OperatorKind::measured) return {};
  if (calibration_for(edit.state, edit.knowledge, edit.bench.optics)) return {};
  return fail(Errc::refused, "name",
              missing_calibration_reason(edit.state, edit.knowledge, edit.bench.optics) +
                  ": prepare it again with lattice.prepare and \"calibrate\": true");
}

}  // namespace

SensorChange use_lattice(const PreparedLattice& lattice) {
  SensorSet change = SensorSet::whole(lattice.settings);
  change.forget(&TrackingSettings::mode_operator);  // whose error would be about this sensor
  return
      [set = set_unchecked_sensor(std::move(change)),
       mode_operator = lattice.settings.tracking.mode_operator](SensorEdit& edit) -> Result<void> {
        if (auto changed = set(edit); !changed) return changed;
        edit.state.tracking.mode_operator = mode_operator;
        if (auto calibrated = check_calibration(edit); !calibrated) return calibrated;
        if (auto drawn = edit.bench.renderers.renew(edit.state); !drawn) return drawn;
        edit.state.pattern = HologramKind::sensor;
        edit.state.painted.reset();
        if (auto sampled = check_sampling(edit.state); !sampled) return sampled;
        if (auto apart = check_sources_apart(edit.state, edit.bench.optics); !apart) return apart;
        return check_reference(edit);
      };
}

LatticeReport report_of(const PreparedLattice& lattice, const SensorEdit& now) {
  LatticeReport report{lattice, is_in_use(lattice, now.state), false, ""};
  SensorEdit edit = now;
  if (auto usable = use_lattice(lattice)(edit); !usable) {
    report.reason = usable.error().reason;
    return report;
  }
  report.calibrated = calibration_for(edit.state, edit.knowledge, edit.bench.optics) != nullptr;
  return report;
}

Result<void> check_request(const LatticeRequest& request, bool calibrate, const SensorEdit& now) {
  SensorEdit edit = now;
  SensorSet change = request.sensor;
  if (calibrate) change.forget(&TrackingSettings::mode_operator);  // there will be a calibration
  if (auto changed = set_unchecked_sensor(std::move(change))(edit); !changed) {
    return changed;
  }
  if (auto drawn = renew_renderer(edit.state); !drawn) return drawn;
  edit.state.pattern = HologramKind::sensor;
  edit.state.aberration.clear();  // the job shows it without one
  edit.state.sequence.clear();
  if (auto sampled = check_sampling(edit.state); !sampled) return sampled;
  if (auto fits = check_layout(edit.state, edit.bench.optics); !fits) return fits;
  if (calibrate || edit.state.tracking.mode_operator != OperatorKind::measured ||
      calibration_for(edit.state, edit.knowledge, edit.bench.optics)) {
    return {};
  }
  return fail(Errc::refused, "operator",
              "the operator measured needs a calibration of this lattice: give \"calibrate\": "
              "true, or another operator");
}

}  // namespace ovws
