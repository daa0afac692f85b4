/// sensor.*, aberration.* and slm.show: all that changes the hologram.
#include "daemon/ovwsd/control/methods.hpp"

namespace ovws {
namespace {

void get(Services& services, Reply<SensorReport> reply) {
  const SensorSnapshot sensor = services.instrument.snapshot();
  reply(SensorReport{{sensor.sensor, sensor.tracking},
                     sensor.templates,
                     sensor.mode_operator,
                     sensor.subapertures,
                     sensor.modes_j,
                     sensor.hologram_id});
}

/// The core names settings as the configuration does, a client as the method's params do.
Error in_params(Error error) {
  for (const std::string_view room : {"sensor.", "tracking."}) {
    if (error.field.starts_with(room)) error.field.erase(0, room.size());
  }
  return error;
}

void set(Services& services, const SensorSet& change, Reply<SensorSetReport> reply) {
  services.instrument.change_sensor(change, [change, reply](Result<SensorSnapshot> applied) {
    if (!applied) return reply(in_params(applied.error()));
    reply(SensorSetReport{change, {applied->sensor, applied->tracking}, applied->hologram_id});
  });
}

auto with_aberration(Reply<ModesReport> reply) {
  return [reply = std::move(reply)](const Result<SensorSnapshot>& applied) {
    if (!applied) return reply(applied.error());
    reply(ModesReport(applied->aberration, applied->hologram_id));
  };
}

void get_aberration(Services& services, Reply<ModesReport> reply) {
  with_aberration(reply)(services.instrument.snapshot());
}

void set_aberration(Services& services, const ModesSet& set, Reply<ModesReport> reply) {
  services.instrument.set_aberration(set.modes, with_aberration(reply));
}

void clear_aberration(Services& services, Reply<ModesReport> reply) {
  services.instrument.set_aberration({}, with_aberration(reply));
}

void show(Services& services, const SlmShow& what, Reply<ShowReport> reply) {
  services.instrument.show(what.pattern.kind, [reply](Result<SensorSnapshot> applied) {
    if (!applied) return reply(applied.error());
    reply(ShowReport{applied->pattern, applied->hologram_id});
  });
}

constexpr std::array kRows{
    row<kSensorGet, get>(Role::read, Action::read),
    row<kSensorSet, set>(Role::control, Action::set_sensor),
    row<kAberrationGet, get_aberration>(Role::read, Action::read),
    row<kAberrationSet, set_aberration>(Role::control, Action::set_aberration),
    row<kAberrationClear, clear_aberration>(Role::control, Action::set_aberration),
    row<kSlmShow, show>(Role::control, Action::show_pattern),
};

}  // namespace

std::span<const MethodRow> sensor_methods() {
  return kRows;
}

}  // namespace ovws
